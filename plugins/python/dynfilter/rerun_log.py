# SPDX-License-Identifier: MIT
"""A run in the viewer of rerun (https://rerun.io), which is not needed for anything else."""

from __future__ import annotations

import importlib
import os
from typing import Any, Dict, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from .compare import Source, run
from .comparison import Run
from .errors import Error
from .keywords import named_arguments
from .sequences import Frame, Sequence, Trajectory


_Colour = Tuple[int, int, int]
_COLOURS: Dict[int, Tuple[str, _Colour]] = {
    _core.UNKNOWN: ("unknown", (150, 150, 150)),
    _core.STATIC: ("static", (60, 190, 90)),
    _core.DYNAMIC: ("dynamic", (225, 60, 60)),
}
_ESTIMATE: _Colour = (40, 120, 220)
_TRUTH: _Colour = (130, 130, 130)
_JPEG_QUALITY = 80
_FEATURE_RADIUS_PX = 3.0


@named_arguments
def to_rerun(
    pipeline: Source,
    sequence: Sequence,
    *,
    frames: Optional[int] = None,
    save: Union[None, str, "os.PathLike[str]"] = None,
    spawn: bool = False,
    application: str = "dynfilter",
) -> Run:
    """Runs a pipeline on a sequence as run() does, and logs it to rerun.

    Logged are per frame: the image, depth, features coloured by their verdict, boxes, the camera's pose, counts and
    times. At the end: the paths of estimate and ground truth, aligned as for the ATE.
    `save`: a file (.rrd) to write. `spawn`: open the viewer. Without both: into the recording that the caller started
    with `rerun.init`. `frames`: at most so many.
    Raises ModuleNotFoundError if rerun is not installed (pip install rerun-sdk, 0.16 or newer).
    """
    rerun = importlib.import_module("rerun")
    if save is not None or spawn:
        rerun.init(application, spawn=spawn)
    if save is not None:
        rerun.save(os.fspath(save))
    log = _Log(rerun, sequence)
    result = run(pipeline, sequence, frames=frames, each=log.add)
    log.finish(result, sequence.ground_truth())
    return result


class _Log:
    def __init__(self, rerun: Any, sequence: Sequence) -> None:
        self._rerun, self._sequence = rerun, sequence
        self._started = False
        # Newer versions have one function for all kinds of time, and another name for numbers.
        self._number = getattr(rerun, "Scalars", None) or rerun.Scalar
        labels = [(number, name, colour) for number, (name, colour) in _COLOURS.items()]
        rerun.log("/", rerun.AnnotationContext(labels), static=True)
        rerun.log("world", rerun.ViewCoordinates.RDF, static=True)

    def add(self, frame: Frame, track: _core.Track) -> None:
        rerun = self._rerun
        self._at(frame)
        if not self._started:
            self._pinhole(frame)
        if track.pose is not None:
            rerun.log("world/camera", rerun.Transform3D(translation=track.pose[:3, 3], mat3x3=track.pose[:3, :3]))
        picture = frame.colour if frame.colour.size else frame.grey
        if picture.ndim == 3:
            picture = np.ascontiguousarray(picture[:, :, ::-1])
        rerun.log("world/camera/image", rerun.Image(picture).compress(jpeg_quality=_JPEG_QUALITY))
        if frame.depth is not None and self._sequence.sensor == "rgbd":
            rerun.log("world/camera/depth", rerun.DepthImage(frame.depth, meter=1 / frame.depth_unit_m))
        rerun.log(
            "world/camera/image/features",
            rerun.Points2D(track.keypoints, class_ids=track.decision.astype(np.uint16), radii=_FEATURE_RADIUS_PX),
        )
        self._boxes(frame)
        counts = {name: int((track.decision == number).sum()) for number, (name, _) in _COLOURS.items()}
        for name, value in {**counts, "tracked": int(track.state == "tracked")}.items():
            rerun.log(f"features/{name}" if name in counts else name, self._number(value))
        rerun.log("ms/pipeline", self._number(track.judge_ms))
        rerun.log("ms/frame", self._number(track.total_ms))

    def finish(self, result: Run, truth: Optional[Trajectory]) -> None:
        """The estimate after bundle adjustment, and the truth in its frame."""
        if result.trajectory is None or len(result.trajectory[0]) == 0:
            return
        # The unit of a mono map is not that of the paths, which are scaled to the truth.
        root = "paths" if self._sequence.sensor == "mono" else "world"
        self._path(f"{root}/estimate", result.trajectory[1][:, :3, 3], _ESTIMATE)
        if truth is None:
            return
        try:
            T = np.linalg.inv(_core.ate(truth, result.trajectory).T_truth_estimate)
        except Error:  # too few poses
            return
        self._path(f"{root}/truth", truth[1][:, :3, 3] @ T[:3, :3].T + T[:3, 3], _TRUTH)

    def _at(self, frame: Frame) -> None:
        if hasattr(self._rerun, "set_time"):
            self._rerun.set_time("frame", sequence=frame.index)
            self._rerun.set_time("time", timestamp=frame.timestamp)
        else:
            self._rerun.set_time_sequence("frame", frame.index)
            self._rerun.set_time_seconds("time", frame.timestamp)

    def _pinhole(self, frame: Frame) -> None:
        camera, self._started = frame.camera, True
        height, width = frame.grey.shape
        pinhole = self._rerun.Pinhole(
            focal_length=[camera.fx_px, camera.fy_px],
            principal_point=[camera.cx_px, camera.cy_px],
            resolution=[width, height],
        )
        self._rerun.log("world/camera", pinhole, static=True)

    def _boxes(self, frame: Frame) -> None:
        if frame.boxes is None:
            return
        sides = np.array([box.box for box in frame.boxes], float).reshape(-1, 4)
        names = [f"{box.class_name} {box.score:.2f}" for box in frame.boxes]
        boxes = self._rerun.Boxes2D(mins=sides[:, :2], sizes=sides[:, 2:], labels=names)
        self._rerun.log("world/camera/image/boxes", boxes)

    def _path(self, name: str, places_m: NDArray[Any], colour: _Colour) -> None:
        self._rerun.log(name, self._rerun.LineStrips3D([places_m], colors=[colour]), static=True)
