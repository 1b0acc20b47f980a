# SPDX-License-Identifier: MIT
"""Cameras that are none are refused, and every array is taken in every form or refused by its name."""

import numpy as np
import pytest
from test_arguments import GREY, PLACES, Spy, seen

import dynfilter

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
