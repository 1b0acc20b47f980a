# SPDX-License-Identifier: MIT
"""A wrong name of an argument, a parameter or a thing is answered with the nearest known one, on one line."""

import inspect
from dataclasses import dataclass

import numpy as np
import pytest

import dynfilter
from dynfilter import _core

PLACES = np.zeros((3, 2), np.float32)


def compiled_calls():
    """(name, its own name, callable) of every function and method of the compiled module."""
    for name, member in vars(_core).items():
        if isinstance(member, type):
            for of_class, method in vars(member).items():
                if not of_class.startswith("__"):
                    yield f"{name}.{of_class}", of_class, method
        else:
            yield name, name, member


CALLS = [
    (name, call)
    for name, own, call in compiled_calls()
    if callable(call) and not isinstance(call, type) and (getattr(call, "__doc__", None) or "").startswith(own + "(")
]
CLASSES = [
    (name, made)
    for name, made in vars(_core).items()
    if isinstance(made, type) and (made.__init__.__doc__ or "").startswith("__init__(self: ")
]
PYTHON_CALLS = [
    (name, call)
    for name, call in vars(dynfilter).items()
    if name in dynfilter.__all__ and inspect.isfunction(call) and call.__module__ != "dynfilter._core"
]


def test_the_lists_above_are_not_empty():
    names = [name for name, _ in CALLS]
    assert {"Pipeline.before_pose", "read_camera", "StaticMap.add"} <= set(names)
    assert {"Camera", "Pipeline", "ExactScene", "StaticMap"} <= {name for name, _ in CLASSES}
    assert {"compare", "run", "judge", "render", "param", "to_rerun"} <= {name for name, _ in PYTHON_CALLS}


@pytest.mark.parametrize("name, call", CALLS, ids=[name for name, _ in CALLS])
def test_every_compiled_call_answers_unknown_arguments(name, call):
    with pytest.raises(TypeError) as e:
        call(*([None] if "." in name else []), surely_unknown=1)
    text = str(e.value)
    assert "incompatible function arguments" not in text and "\n" not in text, text
    assert "unknown argument `surely_unknown`" in text


@pytest.mark.parametrize("name, made", CLASSES, ids=[name for name, _ in CLASSES])
def test_every_compiled_class_answers_unknown_arguments(name, made):
    # A map takes its YAML's keys as arguments.
    error, what = (dynfilter.ConfigError, "") if name == "StaticMap" else (TypeError, f"{name}: ")
    with pytest.raises(error, match=f"^{what}unknown (argument|key) `surely_unknown`"):
        made(surely_unknown=1)


@pytest.mark.parametrize("name, call", PYTHON_CALLS, ids=[name for name, _ in PYTHON_CALLS])
def test_every_python_function_answers_unknown_arguments(name, call):
    with pytest.raises(TypeError, match=f"^{name}: unknown argument `surely_unknown`"):
        call(surely_unknown=1)


@dataclass
class NamesFilter(dynfilter.Filter):
    min_depth_m: float = 0.5

    def apply(self, evidence, votes):
        pass


@pytest.mark.parametrize(
    "call, message",
    [
        (
            lambda: dynfilter.Pipeline("none").before_pose(PLACES, timestamp=0, gray=None),
            r"before_pose: unknown argument `gray` \(did you mean `grey`\?\); known arguments: keypoints, timestamp, .*",
        ),
        (lambda: dynfilter.Pipeline("none").after_pose(PLACES), "after_pose: argument `timestamp` is missing"),
        (lambda: dynfilter.Pipeline("none").before_pose(PLACES, 0.0), "before_pose: at most 1 arguments without a name, got 2; .*"),
        (lambda: dynfilter.Pipeline(), "Pipeline: argument `source` is missing"),
        (lambda: dynfilter.Camera(500, 500, "a", 240), "Camera: cx_px: expected a number, got a str"),
        (lambda: dynfilter.Camera(500, 500, 320, 240, width=640), r"Camera: unknown argument `width` \(did you mean `width_px`\?\).*"),
        (lambda: dynfilter.Camera(500, 500, 320, 240, width_px=64.5), "Camera: width_px: expected an integer, got a float"),
        (lambda: dynfilter.Detection((1, 2, 3, 4), klass="x"), "Detection: unknown argument `klass`.*"),
        (lambda: dynfilter.ExactScene("general", pixel_nose_px=1), r".*did you mean `pixel_noise_px`\?.*"),
        (lambda: dynfilter.compare(pipline=[]), r"compare: unknown argument `pipline` \(did you mean `pipelines`\?\).*"),
        (lambda: dynfilter.render(scenes="x"), r"render: unknown argument `scenes` \(did you mean `scene`\?\).*"),
        (lambda: dynfilter.Recording(".", detection=None), r"Recording: .*\(did you mean `detections`\?\).*"),
        (lambda: NamesFilter(min_depth=1), r"NamesFilter: unknown argument `min_depth` \(did you mean `min_depth_m`\?\).*"),
    ],
)
def test_arguments(call, message):
    with pytest.raises(TypeError, match=f"^{message}$"):
        call()


@pytest.mark.parametrize(
    "call, nearest",
    [
        (lambda: dynfilter.Pipeline("dynfiler"), "dynfilter"),
        (lambda: dynfilter.Pipeline("pipeline: { before_pose: [ epipolr ] }"), "epipolar"),
        (lambda: dynfilter.Pipeline("pipeline: { before_pose: [ { epipolar: { max_distance: 1 } } ] }"), "max_distance_px"),
        (lambda: dynfilter.Pipeline("pipeline: { before_pose: [ { names_filter: { min_depth: 1 } } ] }"), "min_depth_m"),
        (lambda: dynfilter.ExactScene("generl"), "general"),
        (lambda: dynfilter.ExactScene(camera_motion="sidways"), "sideways"),
        (lambda: dynfilter.judge("epipolr", dynfilter.ExactScene()), "epipolar"),
        (lambda: dynfilter.compare(["none"], ["generl"]), "general"),
        (lambda: dynfilter.render("walking_xzy"), "walking_xyz"),
        (lambda: dynfilter.Odometry(dynfilter.ExactScene().camera, sensor="rgd"), "rgbd"),
        (lambda: type("Needy", (dynfilter.Filter,), {}, needs="dept"), "depth"),
        (lambda: dynfilter.Pipeline("none").before_pose(PLACES, timestamp=0, pose=np.eye(4), pose_kind="predict"), "predicted"),
        (lambda: dynfilter.Pipeline("none").before_pose(PLACES, timestamp=0).mask((4, 4), polarity="255_drop"), "255_drops"),
        (lambda: dynfilter.Pipeline("epipolar").before_pose(PLACES, timestamp=0).rejected_by("epipolr"), "epipolar"),
    ],
)
def test_names_of_things(call, nearest):
    if "Odometry" in call.__code__.co_names and not dynfilter.has_odometry:
        pytest.skip("no odometry")
    with pytest.raises(ValueError) as e:
        call()
    assert f"did you mean `{nearest}`?" in str(e.value) and "\n" not in str(e.value)


def test_type_errors_of_a_filter_are_its_own():
    class Faulty(dynfilter.Filter):
        def apply(self, evidence, votes):
            raise TypeError("mine")

    with pytest.raises(TypeError, match="^mine$"):
        dynfilter.Pipeline(Faulty()).before_pose(PLACES, timestamp=0)
