# SPDX-License-Identifier: MIT
"""Rejectors of features on moving objects for visual SLAM.

::

    pipeline = dynfilter.Pipeline("dynfilter")
    verdict = pipeline.before_pose(keypoints, timestamp=t, grey=grey, depth=depth, depth_unit_m=1 / 5000, camera=K)
    keypoints = keypoints[verdict.keep]
"""

from . import _core
from .keywords import explain_calls_of

explain_calls_of(_core)

from ._core import (  # noqa: E402, after the calls were wrapped
    DYNAMIC,
    STATIC,
    UNKNOWN,
    Ate,
    Camera,
    Detection,
    Evidence,
    ExactFrame,
    ExactScene,
    FilterCard,
    Gyroscope,
    Keyframe,
    MapReport,
    Match,
    MotionPrior,
    MovingBox,
    Parameter,
    Pipeline,
    Report,
    Rpe,
    Score,
    StageReport,
    StaticMap,
    Statistics,
    TwoView,
    Verdict,
    Votes,
    __version__,
    ate,
    exact_scene_names,
    filter_cards,
    has_odometry,
    keypoint_type,
    load_plugin,
    presets,
    read_camera,
    read_detections,
    read_gyroscope,
    read_trajectory,
    rpe,
    scene_names,
    write_trajectory,
)
from .compare import Judgement, compare, judge, run, run_scene  # noqa: E402
from .comparison import Comparison, Run  # noqa: E402
from .errors import ConfigError, Error, IoError, PluginError  # noqa: E402
from .filters import Filter, param  # noqa: E402
from .rerun_log import to_rerun  # noqa: E402
from .sequences import Frame, Recording, RenderedSequence, Sequence, render  # noqa: E402

__all__ = [
    "Ate",
    "Camera",
    "Comparison",
    "ConfigError",
    "DYNAMIC",
    "Detection",
    "Error",
    "Evidence",
    "ExactFrame",
    "ExactScene",
    "Filter",
    "FilterCard",
    "Frame",
    "Gyroscope",
    "IoError",
    "Judgement",
    "Keyframe",
    "MapReport",
    "Match",
    "MotionPrior",
    "MovingBox",
    "Parameter",
    "Pipeline",
    "PluginError",
    "Recording",
    "RenderedSequence",
    "Report",
    "Rpe",
    "Run",
    "STATIC",
    "Score",
    "Sequence",
    "StageReport",
    "StaticMap",
    "Statistics",
    "TwoView",
    "UNKNOWN",
    "Verdict",
    "Votes",
    "__version__",
    "ate",
    "compare",
    "exact_scene_names",
    "filter_cards",
    "has_odometry",
    "judge",
    "keypoint_type",
    "load_plugin",
    "param",
    "presets",
    "read_camera",
    "read_detections",
    "read_gyroscope",
    "read_trajectory",
    "render",
    "rpe",
    "run",
    "run_scene",
    "scene_names",
    "to_rerun",
    "write_trajectory",
]

if has_odometry:
    from ._core import Classification, Odometry, Track

    __all__ += ["Classification", "Odometry", "Track"]
