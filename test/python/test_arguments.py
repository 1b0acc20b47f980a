# SPDX-License-Identifier: MIT
"""Every wrong argument is a ValueError that names it; every accepted form means the same."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

import dynfilter

N = 3
PLACES = np.float32([[10.5, 20.25], [30, 40], [50, 60]])
CAMERA = dynfilter.Camera(500, 500, 32, 24, width_px=64, height_px=48)
GREY = np.zeros((48, 64), np.uint8)


class Spy(dynfilter.Filter):
    """Keeps what it saw."""

    def apply(self, evidence, votes):
        self.seen = {
            name: getattr(evidence, name)
            for name in ("pixels", "octaves", "depths_m", "grey", "depth", "mask", "boxes", "camera", "pose")
        }


def seen(**arguments):
    spy = Spy()
    dynfilter.Pipeline(spy).before_pose(**{"keypoints": PLACES, "timestamp": 0.0, **arguments})
    return spy.seen


def test_keypoints_of_every_form():
    objects = [cv2.KeyPoint(float(x), float(y), 31.0, octave=k) for k, (x, y) in enumerate(PLACES)]
    records = np.zeros(N, dynfilter.keypoint_type)
    records["x"], records["y"], records["octave"] = PLACES[:, 0], PLACES[:, 1], [0, 1, 2]
    alike = [SimpleNamespace(pt=(float(x), float(y)), octave=k) for k, (x, y) in enumerate(PLACES)]
    mixed = [alike[0], *objects[1:]], [objects[0], *alike[1:]]
    forms = [objects, tuple(objects), records, alike, *mixed, PLACES, PLACES.astype(np.float64), PLACES.tolist(), PLACES[::-1][::-1]]
    for keypoints in forms:
        np.testing.assert_array_equal(seen(keypoints=keypoints)["pixels"], PLACES)
    for keypoints in forms[:6]:
        assert list(seen(keypoints=keypoints)["octaves"]) == [0, 1, 2]
    for keypoints in forms:
        assert list(seen(keypoints=keypoints, octaves=[3, 4, 5])["octaves"]) == [3, 4, 5]
    for none in ([], (), np.zeros((0, 2), np.float32), np.zeros(0)):
        assert len(seen(keypoints=none)["pixels"]) == 0


def test_images_are_not_copied():
    depth = np.ones((48, 64), np.float32)
    mask = np.zeros((48, 64), bool)
    frame = seen(grey=GREY, depth=depth, mask=mask)
    for name, given in (("grey", GREY), ("depth", depth), ("mask", mask)):
        assert np.shares_memory(frame[name], given), name
        assert not frame[name].flags.writeable


def test_rows_with_gaps_are_not_copied_other_layouts_are():
    wide = np.arange(48 * 80, dtype=np.uint8).reshape(48, 80)
    assert np.shares_memory(seen(grey=wide[:, 8:72])["grey"], wide)
    colour = np.arange(48 * 64 * 3, dtype=np.uint8).reshape(48, 64, 3)
    np.testing.assert_array_equal(seen(grey=colour[:, :, 1])["grey"], colour[:, :, 1])
    np.testing.assert_array_equal(seen(grey=wide[::-1, :64])["grey"], wide[::-1, :64])


def test_depth_and_camera():
    depth = np.full((48, 64), 5000, np.uint16)
    frame = seen(depth=depth, depth_unit_m=1 / 5000, camera=CAMERA)
    np.testing.assert_allclose(frame["depths_m"], [1, 1, np.nan])  # the third is below the image
    assert frame["camera"] == CAMERA
    K = np.array([[500, 0, 32], [0, 500, 24], [0, 0, 1.0]])
    assert seen(camera=K)["camera"].fx_px == 500
    np.testing.assert_array_equal(CAMERA.matrix, K)


def test_boxes_pose_and_none():
    box = dynfilter.Detection((1, 2, 3, 4), "person", 0.5, track_id=7)
    found = seen(boxes=[box])["boxes"]
    assert [(b.box, b.class_name, b.score, b.track_id) for b in found] == [((1, 2, 3, 4), "person", 0.5, 7)]
    assert seen(boxes=[])["boxes"] == [] and seen()["boxes"] is None
    pose = np.eye(4)
    pose[:3, 3] = 1, 2, 3
    np.testing.assert_array_equal(seen(pose=pose)["pose"], pose)
    assert seen()["pose"] is None and seen()["grey"] is None


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"keypoints": np.zeros((3, 3))}, r"keypoints: expected numbers of shape \(n, 2\), got an array of shape \(3, 3\)"),
        ({"keypoints": "abc"}, "keypoints: expected"),
        ({"keypoints": None}, "keypoints: expected"),
        ({"keypoints": [cv2.KeyPoint(1, 2, 3), 4]}, "keypoints: expected only objects of cv2.KeyPoint"),
        ({"keypoints": np.array([["a", "b"]])}, "keypoints: expected numbers"),
        ({"timestamp": "now"}, "timestamp: expected a number, got a str"),
        ({"timestamp": None}, "timestamp: expected a number, got None"),
        ({"frame_id": 1.5}, "frame_id: expected an integer, got a float"),
        ({"min_features": "all"}, "min_features: expected an integer"),
        ({"octaves": [1, 2]}, r"octaves: expected integers of shape \(3,\), got an array of shape \(2,\)"),
        ({"octaves": [0.5, 1, 2]}, "octaves: expected integers"),
        ({"keypoints_undistorted": np.zeros((2, 2))}, "keypoints_undistorted: expected"),
        ({"descriptors": np.zeros((2, 32), np.uint8)}, r"descriptors: expected uint8 of shape \(3, bytes\)"),
        ({"descriptors": np.zeros((3, 32), np.float32)}, "descriptors: expected"),
        ({"depth_m": [1, 2]}, r"depth_m: expected numbers of shape \(3,\)"),
        ({"right_u_px": [1, 2]}, r"right_u_px: expected numbers of shape \(3,\)"),
        ({"grey": np.zeros((48, 64, 3), np.uint8)}, r"grey: expected a uint8 image of shape \(height, width\)"),
        ({"grey": np.zeros((48, 64))}, "grey: expected a uint8 image.*float64"),
        ({"grey": "image.png"}, "grey: expected a uint8 image.*got a str"),
        ({"depth": np.zeros((48, 64))}, "depth: expected a float32 or uint16 image.*float64"),
        ({"depth": np.zeros((48, 64), ">u2")}, "depth: expected a float32 or uint16 image"),
        ({"depth": np.zeros((48, 64), np.uint16)}, "depth_unit_m: needed for a uint16 depth image"),
        ({"depth": np.zeros((48, 65), np.float32), "grey": GREY}, "depth: expected the size of `grey`"),
        ({"depth_unit_m": "mm", "depth": np.zeros((48, 64), np.uint16)}, "depth_unit_m: expected a number"),
        ({"camera": (500, 500, 320, 240)}, r"camera: expected a dynfilter.Camera or a \(3, 3\) matrix, got a tuple"),
        ({"camera": np.eye(4)}, r"camera: expected numbers of shape \(3, 3\)"),
        ({"pose": np.eye(3)}, r"pose: expected numbers of shape \(4, 4\)"),
        ({"pose": 2 * np.eye(4)}, "pose: expected a rigid motion"),
        ({"pose": np.eye(4), "pose_kind": "guess"}, "pose_kind: expected one of predicted, estimated, refined, got `guess`"),
        ({"boxes": [(1, 2, 3, 4)]}, "boxes: expected a list of dynfilter.Detection, got a tuple"),
        ({"boxes": 5}, "boxes: expected a list of dynfilter.Detection, got a int"),
        ({"mask": np.zeros((48, 64), np.int64)}, "mask: expected a uint8 or bool image"),
        ({"matches": [0, 1]}, r"matches: expected integers of shape \(3,\)"),
        ({"matches": [0.0, 1.5, 2]}, "matches: expected integers"),
        ({"map_point_ids": [1]}, "map_point_ids: expected"),
        ({"map_points_m": np.zeros((3, 2))}, r"map_points_m: expected numbers of shape \(3, 3\)"),
        ({"keyframes": [1]}, "keyframes: expected a list of dynfilter.Keyframe, got a int"),
        ({"keyframes": 5}, "keyframes: expected a list of dynfilter.Keyframe"),
    ],
)
def test_wrong_arguments_are_named(arguments, message):
    with pytest.raises(ValueError, match="^" + message):
        seen(**arguments)


def test_values_of_classes_are_checked():
    with pytest.raises(ValueError, match="^Camera: expected focal lengths fx, fy above 0 .px., got 0.0, 500.0$"):
        dynfilter.Camera(0, 500, 320, 240)
    with pytest.raises(ValueError, match="distortion: expected 0, 4 or 5 numbers k1 k2 p1 p2 k3, got 8"):
        dynfilter.Camera(500, 500, 320, 240, distortion=[0] * 8)
    with pytest.raises(ValueError, match=r"box: expected numbers of shape \(4,\)"):
        dynfilter.Detection((1, 2, 3))


NAN, INF = float("nan"), float("inf")
K = np.array([[500, 0, 32], [0, 500, 24], [0, 0, 1.0]])


def changed(row, column, value):
    other = K.copy()
    other[row, column] = value
    return other


@pytest.mark.parametrize(
    "camera, message",
    [
        (np.zeros((3, 3)), "expected a matrix with the bottom row 0 0 1, got 0.0 0.0 0.0"),
        (np.full((3, 3), NAN), "expected a matrix with the bottom row 0 0 1"),
        (np.eye(3) * 500, "expected a matrix with the bottom row 0 0 1, got 0.0 0.0 500.0"),
        (np.diag([500, 500, 1.0]), "expected a principal point cx, cy inside the image .px., got 0.0, 0.0"),
        (K.T, "expected a matrix with the bottom row 0 0 1"),
        (K[:2], r"expected numbers of shape \(3, 3\), got an array of shape \(2, 3\)"),
        (np.ones(9), r"expected a dynfilter.Camera or a \(3, 3\) matrix"),
        (K.astype(complex), "expected numbers"),
        (K.astype(object), "expected numbers"),
        (changed(0, 0, -500), "expected focal lengths fx, fy above 0 .px., got -500.0, 500.0"),
        (changed(1, 1, INF), "expected focal lengths"),
        (changed(1, 1, NAN), "expected focal lengths"),
        (changed(0, 1, 0.5), "expected a matrix without skew, got 0.5 in row 0 and 0.0 in row 1"),
        (changed(1, 0, 0.5), "expected a matrix without skew"),
        (changed(0, 1, NAN), "expected a matrix without skew"),
        (changed(2, 0, 1), "expected a matrix with the bottom row"),
        (changed(0, 2, -1), "expected a principal point"),
        (changed(0, 2, 64), "expected a principal point cx, cy inside the image .px., got 64.0, 24.0"),
        (changed(1, 2, 48), "expected a principal point"),
        (changed(1, 2, NAN), "expected a principal point"),
    ],
)
def test_matrices_that_are_no_camera(camera, message):
    with pytest.raises(ValueError, match="^camera: " + message):
        seen(camera=camera, grey=GREY)


def test_every_entry_of_a_camera_is_checked():
    """No entry can be NaN, infinite or negative, in a matrix and in a Camera."""
    for bad in (NAN, INF, -INF, -1e9):
        for row in range(3):
            for column in range(3):
                with pytest.raises(ValueError, match="^camera: expected"):
                    seen(camera=changed(row, column, bad), grey=GREY)
        good = {"fx_px": 500, "fy_px": 500, "cx_px": 32, "cy_px": 24, "baseline_fx_px_m": 40.0}
        for name in good:
            with pytest.raises(ValueError, match="^(Camera|baseline_fx_px_m): expected"):
                dynfilter.Camera(**{**good, name: bad})
        for i in range(5):
            distortion = [0.1, 0.01, 0, 0, 0]
            distortion[i] = bad
            if np.isfinite(bad):
                continue
            with pytest.raises(ValueError, match="^distortion: expected finite numbers"):
                dynfilter.Camera(**good, distortion=distortion)


def test_cameras_that_are_accepted():
    plain = seen(camera=K)["camera"]
    for other in (K.astype(np.float32), np.asfortranarray(K), K.tolist(), np.round(K).astype(int)):
        assert seen(camera=other)["camera"] == plain
    almost = K.copy()
    almost[0, 1], almost[2, 2] = 1e-12, 1 - 1e-12  # products of matrices
    assert seen(camera=almost)["camera"] == plain
    assert seen(camera=changed(0, 2, 320))["camera"].cx_px == 320  # without an image any place above 0
    for n in (1, 2, 3, 6, 8, 14):
        with pytest.raises(ValueError, match=f"^distortion: expected 0, 4 or 5 numbers k1 k2 p1 p2 k3, got {n}"):
            dynfilter.Camera(500, 500, 32, 24, distortion=[0.1] * n)
    for like_opencv in (np.ones((1, 5)), np.ones((5, 1)), np.ones(5), [1] * 5):
        assert dynfilter.Camera(500, 500, 32, 24, distortion=like_opencv).distortion == (1,) * 5
    for wrong in (np.ones((2, 2)), "abc", None, [["a"]]):
        with pytest.raises(ValueError, match="^distortion: expected"):
            dynfilter.Camera(500, 500, 32, 24, distortion=wrong)
    with pytest.raises(ValueError, match="^Camera: expected a principal point cx, cy inside the image"):
        dynfilter.Camera(500, 500, 320, 240, width_px=320, height_px=480)
    with pytest.raises(ValueError, match="^Camera: expected an image size"):
        dynfilter.Camera(500, 500, 320, 240, width_px=-1)


class Tensor:
    """An array of another library."""

    def __init__(self, array, fails=False):
        self.array, self.fails = array, fails

    def __array__(self, dtype=None, copy=None):
        if self.fails:
            raise TypeError("not on this device")
        return self.array


ARRAYS = {
    "keypoints": PLACES,
    "octaves": np.array([0, 1, 2], np.int32),
    "keypoints_undistorted": PLACES,
    "descriptors": np.arange(96, dtype=np.uint8).reshape(3, 32),
    "depth_m": np.float32([1, 2, 3]),
    "right_u_px": np.float32([1, 2, 3]),
    "grey": np.arange(48 * 64, dtype=np.uint8).reshape(48, 64),
    "depth": np.ones((48, 64), np.float32),
    "camera": K,
    "pose": np.eye(4),
    "mask": np.ones((48, 64), np.uint8),
    "matches": np.array([0, 1, -1], np.int32),
    "map_point_ids": np.array([0, 1, -1], np.int64),
    "map_points_m": np.ones((3, 3), np.float32),
}


def strided(array):
    """The same values, with gaps and the axes in another order in memory."""
    wide = np.zeros(tuple(2 * n for n in array.shape[::-1]), array.dtype).T
    view = wide[tuple(slice(None, None, 2) for _ in array.shape)]
    view[...] = array
    assert not view.flags.c_contiguous
    return view


def judged(**arguments):
    spy = Spy()
    verdict = dynfilter.Pipeline(spy).before_pose(**{"keypoints": PLACES, "timestamp": 0.0, **arguments})
    return {**spy.seen, "n": len(verdict)}


def same(a, b):
    if a is None or not isinstance(a, np.ndarray):
        return a == b
    return np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


@pytest.mark.parametrize("name", ARRAYS)
def test_every_array_in_every_form(name):
    """Every form is either the same to the filters, or refused by its argument's name. Nothing else is raised."""
    array = ARRAYS[name]
    plain = judged(**{name: array})
    accepted = {
        "strided": strided(array),
        "reversed twice": array[::-1].copy()[::-1],
        "Fortran": np.asfortranarray(array),
        "read only": array.copy(),
        "with __array__": Tensor(array),
        "subclass": array.view(type("Sub", (np.ndarray,), {})),
    }
    accepted["read only"].flags.writeable = False
    for form, given in accepted.items():
        got = judged(**{name: given})
        for key, value in plain.items():
            assert same(value, got[key]), (form, key)
    refused = {
        "complex": array.astype(complex),
        "object": array.astype(object),
        "text": array.astype("U8"),
        "dates": array.astype(np.int64).astype("M8[s]"),
        "more axes": array[None, None],
        "no axes": np.float64(3),
        "fewer rows": array[:-1] if name not in ("keypoints", "grey", "depth", "mask") else array[0],
        "masked": np.ma.masked_array(array, mask=np.zeros(array.shape, bool)),
        "__array__ that fails": Tensor(array, fails=True),
        "a set": {1, 2},
        "a function": len,
        "a text": "abc",
        "bytes": b"abc",
    }
    for form, given in refused.items():
        with pytest.raises(ValueError, match=f"^{name}: expected") as e:
            judged(**{name: given})
        assert "\n" not in str(e.value), form


def test_integers_that_do_not_fit_are_refused():
    for wrong in ([2**32, 0, 0], np.array([2**31, 0, 0]), np.array([2**63, 0, 0], np.uint64), [-(2**31) - 1, 0, 0]):
        with pytest.raises(ValueError, match="^matches: expected integers"):
            seen(matches=wrong)
    with pytest.raises(ValueError, match="^map_point_ids: expected integers"):
        seen(map_point_ids=np.array([2**63, 0, 0], np.uint64))
    seen(matches=np.array([0, 1, 2], np.uint64), map_point_ids=np.array([2**62, 0, -1]))


@pytest.mark.parametrize("unit", [0, -1, NAN, INF])
def test_units_of_depth(unit):
    with pytest.raises(ValueError, match="^depth_unit_m: expected a finite number above 0"):
        seen(depth=np.ones((48, 64), np.uint16), depth_unit_m=unit)


def test_limits_of_the_host():
    for wrong in (-1, 2**31, 2**40):
        with pytest.raises(ValueError, match="^min_features: expected 0 or more"):
            seen(min_features=wrong)


def test_nothing_is_kept_after_the_call():
    import sys

    grey = np.zeros((48, 64), np.uint8)
    before = sys.getrefcount(grey)
    pipeline = dynfilter.Pipeline("dynfilter")
    for t in (0.0, 0.1, 0.2):
        pipeline.before_pose(PLACES, timestamp=t, grey=grey, camera=CAMERA)
    assert sys.getrefcount(grey) == before
