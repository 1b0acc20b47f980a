# SPDX-License-Identifier: MIT
"""Filters and pipelines on exact scenes and on sequences, as figures."""

from __future__ import annotations

import math
import os
import statistics
from collections import Counter
from dataclasses import dataclass
from typing import Any, Callable, Iterable, List, Optional, Union

from . import _core
from .comparison import Comparison, Run
from .errors import Error
from .filters import Filter
from .keywords import named_arguments
from .playing import File, motion_priors, own_stamps, played
from .sequences import Frame, Recording, Sequence, Trajectory

Source = Union[str, Filter]
"""A preset, a file, YAML text or a filter."""

_FIRST_FRAME = 5
"""Frames of an exact scene before this one are not counted: filters fill their state."""
_LAST_FRAME = 14
_VARIANTS = [
    (f"{'reverse' if reverse else 'forward'} from {start}", start, reverse)
    for reverse in (False, True)
    for start in (0, 5, 10)
]
"""As `dynfilter compare --variants` plays them."""


@dataclass
class Judgement:
    """Votes of one filter on one frame of an exact scene."""

    decision: Any
    """(n,) uint8: 0 unknown, 1 static, 2 dynamic"""
    score: _core.Score

    @property
    def recall(self) -> float:
        return self.score.recall

    @property
    def precision(self) -> float:
        return self.score.precision

    @property
    def static_kept(self) -> float:
        return self.score.static_kept


@named_arguments
def judge(filter: Source, scene: _core.ExactScene, frame: int = 8) -> Judgement:
    """Votes of a single filter on a frame of an exact scene, after all frames before it.

    `filter`: an object, or the name of a filter, with its default parameters. Without a pipeline there is no floor.
    Raises ConfigError if the scene lacks an input that the filter needs, and whatever the filter raises.
    """
    decision, score = _core._judge(filter, scene, frame)
    return Judgement(decision, score)


@named_arguments
def run_scene(pipeline: Source, scene: _core.ExactScene, name: str = "exact scene") -> Run:
    """Runs a pipeline on frames 0 to 14 of an exact scene, and counts from frame 5 on."""
    judged = _core.Pipeline(pipeline)
    score, times, stages, any_judged = _core.Score(), [], _Stages(), False
    for k in range(_LAST_FRAME + 1):
        frame = scene.frame(k)
        verdict = judged.before_pose(**frame.arguments())
        times.append(verdict.report.total_ms)
        stages.add(verdict.report)
        any_judged = any_judged or bool((verdict.decision != _core.UNKNOWN).any())
        if k >= _FIRST_FRAME:
            score.add(verdict.decision, frame)
    result = Run(judged.name, name, frames=len(times), tracked_frames=len(times), judge_ms=statistics.median(times))
    result.failure, result.notes = stages.failure(), stages.notes(any_judged)
    if not result.failure:
        result.precision = _share(score.precision, score.dynamic_found + score.static_lost)
        result.recall = _share(score.recall, score.dynamic_count)
        result.static_kept = _share(score.static_kept, score.static_count)
    return result


class _Stages:
    """Stages of all frames, where there is no odometry that counts them."""

    def __init__(self) -> None:
        self._frames: "Counter[str]" = Counter()
        self._notes: "Counter[str]" = Counter()
        self._failed: "Counter[str]" = Counter()

    def add(self, report: _core.Report) -> None:
        for stage in report.stages:
            self._frames[stage.path] += 1
            if stage.failed:
                self._failed[stage.path] += 1
            if stage.skipped or stage.failed:
                self._notes[f"{stage.name}: {stage.note}"] += 1

    def failure(self) -> str:
        for path, times in self._failed.items():
            if times == self._frames[path]:
                return f"{path} failed on every frame"
        return ""

    def notes(self, any_judged: bool) -> List[str]:
        notes = [] if any_judged or not self._frames else ["every feature of every frame is unknown"]
        return notes + [f"{note} ({n} frame{'' if n == 1 else 's'})" for note, n in sorted(self._notes.items())]


def _share(value: float, of: int) -> float:
    return value if of > 0 else math.nan


@named_arguments
def run(
    pipeline: Source,
    sequence: Sequence,
    *,
    frames: Optional[int] = None,
    each: Optional[Callable[[Frame, _core.Track], None]] = None,
    start: int = 0,
    reverse: bool = False,
    imu: File = None,
    wheel_odometry: File = None,
) -> Run:
    """Runs the reference odometry with a pipeline on a sequence, as `dynfilter run` does.

    `pipeline`: also "none" and, where the sequence has labels, "oracle". `frames`: at most so many.
    `each`: is called after every frame, with the frame and what the odometry made of it.
    `reverse`: from the last frame to the first. `start`: leaves out the first frames, of the reversed sequence then.
    `imu`: a file with a gyroscope's samples, see read_gyroscope(); "auto": that of the recording's folder.
    `wheel_odometry`: a trajectory of the camera that was measured without images, in TUM's format.
    """
    return _run(pipeline, sequence, frames, each, start, reverse, imu, wheel_odometry, 0)


def _run(
    pipeline: Source,
    sequence: Sequence,
    frames: Optional[int],
    each: Optional[Callable[[Frame, _core.Track], None]],
    start: int,
    reverse: bool,
    imu: File,
    wheel_odometry: File,
    recorded_runs: int,
) -> Run:
    """`recorded_runs`: of a report that this run is one of; 0: there is none."""
    if not _core.has_odometry:
        raise NotImplementedError("this build has no odometry: it needs Ceres, fmt and nlohmann-json")
    guessed = isinstance(sequence, Recording) and sequence.camera_is_guessed
    odometry = _core.Odometry(sequence.camera, pipeline, sensor=sequence.sensor, poses=not guessed)
    if recorded_runs > 0:
        odometry._record(len(sequence) if frames is None else min(frames, len(sequence)), recorded_runs)
    priors = motion_priors(sequence, imu, wheel_odometry)
    where = str(sequence.folder) if isinstance(sequence, Recording) else sequence.name
    counts, times, cpu_times, tracked, n = _core.Classification(), [], [], 0, 0
    stamps: "dict[float, float]" = {}
    for frame in played(sequence, start, reverse):
        if frames is not None and n >= frames:
            break
        odometry._require_labels(where, frame.labels is not None)
        stamp = frame.timestamp
        shown = 2 * next(iter(stamps.values()), stamp) - stamp if reverse else stamp  # time has to increase
        stamps[shown] = stamp
        track = odometry.process(
            frame.grey,
            timestamp=shown,
            right=frame.right if sequence.sensor == "stereo" else None,
            depth=frame.depth if sequence.sensor == "rgbd" else None,
            depth_unit_m=frame.depth_unit_m,
            boxes=frame.boxes,
            boxes_frame_id=frame.boxes_frame_id,
            mask=frame.mask,
            labels=frame.labels,
            motion_prior=priors.next(stamp),
        )
        priors.tracked(track.pose)
        truth = frame.truth if not reverse else None  # it is of motion over earlier frames
        if truth is not None and n >= _core.Classification.first_frame:
            counts.add(truth, track.keypoints, track.decision == _core.DYNAMIC)
        if recorded_runs > 0:
            odometry._see(frame.index, stamp, sequence.name, frame.colour, truth, frame.boxes, frame.mask)
        if each is not None:
            each(frame, track)
        tracked += track.state == "tracked"
        times.append(track.judge_ms)
        cpu_times.append(track.cpu_ms)
        n += 1
    result = Run(odometry.pipeline, sequence.name, scene=sequence.scene or sequence.name, frames=n, tracked_frames=tracked)
    result.trajectory = own_stamps(odometry.trajectory(), stamps)
    result.alignment = "Sim(3)" if sequence.sensor == "mono" else "SE(3)"
    if times:
        result.judge_ms, result.cpu_ms = statistics.median(times), statistics.median(cpu_times)
        own = list(stamps.values())
        result.first_s, result.last_s = own[0], own[-1]
    result.failure, result.notes = odometry.failure, odometry.notes + priors.notes
    if guessed:
        result.notes.append("the camera is not known: verdicts only, no trajectory")
    if not result.failure:
        result.precision, result.recall, result.static_kept = counts.precision, counts.recall, counts.static_kept
        if sequence.sensor == "mono":  # a map that was started again has lost its poses
            result.tracked_frames = len(odometry.trajectory()[0])
        _add_errors(result, sequence.ground_truth(), sequence.sensor == "mono")
    if recorded_runs > 0:
        result._record = odometry._recorded(result, result.trajectory, sequence.ground_truth(), guessed)
    return result


def _add_errors(result: Run, truth: Optional[Trajectory], mono: bool) -> None:
    """A mono map has its own unit: it is scaled to the truth."""
    if truth is None or result.trajectory is None:
        return
    try:
        if mono:
            result.trajectory[1][:, :3, 3] *= _core.ate(truth, result.trajectory, scale=True).scale
        result.ate_rmse_m = _core.ate(truth, result.trajectory).rmse_m
        rpe = _core.rpe(truth, result.trajectory)
        result.rpe_trans_rmse_m, result.rpe_rot_rmse_deg = rpe.translation_m.rmse, rpe.rotation_deg.rmse
    except Error:  # too few poses, or shorter than a second: NaN
        pass


@named_arguments
def compare(
    pipelines: Iterable[Source],
    on: Iterable[Union[str, _core.ExactScene, Sequence]],
    *,
    frames: Optional[int] = None,
    variants: bool = False,
    reference: str = "",
    pictures: bool = True,
    imu: File = None,
    wheel_odometry: File = None,
) -> Comparison:
    """Runs every pipeline on every sequence or scene. Print the result, or see Comparison.to_latex() and report().

    `pipelines`: presets, files, YAML text or filters.
    `on`: names of exact_scene_names(), ExactScene, Recording, render(...). Seeds of a scene are pooled in the tables.
    `variants`: six runs per sequence: forward and in reverse, from frames 0, 5 and 10.
    `reference`: pipeline that a paired test compares the others with; "": `none`, else the first one.
    `pictures`: for report(); False saves their time.
    `imu`, `wheel_odometry`: of every sequence, as for run().

    Rows are told apart by names. Raises Error for two pipelines of one name, or a folder that is given twice.
    Filters of one class with other parameters, and folders of the same name, get longer names.
    """
    judged, places = list(pipelines), list(on)
    names, place_names = _pipeline_names(judged), _place_names(places)
    if reference and reference not in names:
        raise Error(f"reference: `{reference}` is none of the pipelines: {', '.join(names)}")
    plays = _VARIANTS if variants else [("", 0, False)]
    on_sequences = sum(isinstance(place, Sequence) for place in places)
    recorded = on_sequences * len(judged) * len(plays) if pictures else 0
    runs = Comparison()
    runs.reference = reference
    for place, place_name in zip(places, place_names):
        for pipeline, name in zip(judged, names):
            for variant, start, reverse in plays if isinstance(place, Sequence) else plays[:1]:
                if isinstance(pipeline, Filter):
                    pipeline.reset()
                if isinstance(place, Sequence):
                    done = _run(pipeline, place, frames, None, start, reverse, imu, wheel_odometry, recorded)
                    done.variant = variant
                    done.scene = place.scene or place_name
                else:
                    scene = _core.ExactScene(place) if isinstance(place, str) else place
                    done = run_scene(pipeline, scene)
                    done.scene = place_name
                done.pipeline, done.sequence = name, place_name
                runs.append(done)
    return runs


def _pipeline_names(judged: List[Source]) -> List[str]:
    names = [_core._pipeline_name(pipeline) for pipeline in judged]
    named = Counter(names)
    for i, pipeline in enumerate(judged):
        if isinstance(pipeline, Filter) and named[names[i]] > 1:
            names[i] = repr(pipeline)
    sources = [os.fspath(pipeline) if not isinstance(pipeline, Filter) else repr(pipeline) for pipeline in judged]
    _core._check_distinct(list(zip(names, sources)))
    return names


def _place_names(places: List[Any]) -> List[str]:
    """Folders of one name get their parents', the others of one name a number."""
    for i, place in enumerate(places):
        if any(place is other for other in places[:i]):
            raise Error(f"`{_place_name(place)}` is given twice")
    folders = [i for i, place in enumerate(places) if isinstance(place, Recording)]
    names = [_place_name(place) for place in places]
    for i, name in zip(folders, _core._distinct_names([str(places[i].folder) for i in folders])):
        names[i] = name
    named = Counter(names)
    count: "Counter[str]" = Counter()
    for i, name in enumerate(names):
        if named[name] > 1:
            count[name] += 1
            names[i] = f"{name} ({count[name]})"
    return names


def _place_name(place: Any) -> str:
    if isinstance(place, str):
        return place
    return "exact scene" if isinstance(place, _core.ExactScene) else str(place.name)
