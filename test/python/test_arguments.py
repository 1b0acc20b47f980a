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


def test_nothing_is_kept_after_the_call():
    import sys

    grey = np.zeros((48, 64), np.uint8)
    before = sys.getrefcount(grey)
    pipeline = dynfilter.Pipeline("dynfilter")
    for t in (0.0, 0.1, 0.2):
        pipeline.before_pose(PLACES, timestamp=t, grey=grey, camera=CAMERA)
    assert sys.getrefcount(grey) == before
