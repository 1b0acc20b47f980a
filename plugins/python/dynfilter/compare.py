# SPDX-License-Identifier: MIT
"""Filters and pipelines on exact scenes and on sequences, as figures."""

from __future__ import annotations

import math
import os
import statistics
from collections import Counter
from dataclasses import dataclass, field
from typing import Any, Callable, Iterable, List, Optional, Sequence as Many, Tuple, Union

from . import _core
from .errors import Error
from .filters import Filter
from .keywords import named_arguments
from .sequences import Frame, Recording, Sequence, Trajectory

Source = Union[str, Filter]
"""A preset, a file, YAML text or a filter."""

_FIRST_FRAME = 5
"""Frames of an exact scene before this one are not counted: filters fill their state."""
_LAST_FRAME = 14


@dataclass
class Run:
    """One pipeline on one sequence or scene. NaN where there is nothing to compare with."""

    pipeline: str
    sequence: str
    frames: int = 0
    tracked_frames: int = 0
    """Read it beside the ATE: lost frames flatter the ATE."""
    ate_rmse_m: float = math.nan
    rpe_trans_rmse_m: float = math.nan
    rpe_rot_rmse_deg: float = math.nan
    precision: float = math.nan
    recall: float = math.nan
    """Share of the dynamic features that were rejected."""
    static_kept: float = math.nan
    """Share of the static features that were kept."""
    judge_ms: float = math.nan
    """Median time of all calls of the pipeline, per frame."""
    failure: str = ""
    """A stage that failed in every frame. The other figures are then NaN: they would be of another pipeline."""
    notes: List[str] = field(default_factory=list, repr=False)
    """Stages that were skipped or failed, with the number of frames."""
    trajectory: Optional[Trajectory] = field(default=None, repr=False)


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
) -> Run:
    """Runs the reference odometry with a pipeline on a sequence, as `dynfilter run` does.

    `pipeline`: also "none" and, where the sequence has labels, "oracle". `frames`: at most so many.
    `each`: is called after every frame, with the frame and what the odometry made of it.
    """
    if not _core.has_odometry:
        raise NotImplementedError("this build has no odometry: it needs Ceres, fmt and nlohmann-json")
    guessed = isinstance(sequence, Recording) and sequence.camera_is_guessed
    odometry = _core.Odometry(sequence.camera, pipeline, sensor=sequence.sensor, poses=not guessed)
    where = str(sequence.folder) if isinstance(sequence, Recording) else sequence.name
    counts, times, tracked, n = _core.Classification(), [], 0, 0
    for frame in sequence:
        if frames is not None and n >= frames:
            break
        odometry._require_labels(where, frame.labels is not None)
        track = odometry.process(
            frame.grey,
            timestamp=frame.timestamp,
            right=frame.right if sequence.sensor == "stereo" else None,
            depth=frame.depth if sequence.sensor == "rgbd" else None,
            depth_unit_m=frame.depth_unit_m,
            boxes=frame.boxes,
            boxes_frame_id=frame.boxes_frame_id,
            mask=frame.mask,
            labels=frame.labels,
        )
        if frame.truth is not None and n >= _core.Classification.first_frame:
            counts.add(frame.truth, track.keypoints, track.decision == _core.DYNAMIC)
        if each is not None:
            each(frame, track)
        tracked += track.state == "tracked"
        times.append(track.judge_ms)
        n += 1
    result = Run(odometry.pipeline, sequence.name, n, tracked, trajectory=odometry.trajectory())
    result.judge_ms = statistics.median(times) if times else math.nan
    result.failure, result.notes = odometry.failure, odometry.notes
    if guessed:
        result.notes.append("the camera is not known: verdicts only, no trajectory")
    if result.failure:
        return result
    result.precision, result.recall, result.static_kept = counts.precision, counts.recall, counts.static_kept
    if sequence.sensor == "mono":  # a map that was started again has lost its poses
        result.tracked_frames = len(odometry.trajectory()[0])
    _add_errors(result, sequence.ground_truth(), sequence.sensor == "mono")
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


class Comparison(List[Run]):
    """Runs, printed as a table."""

    _COLUMNS: Many[Tuple[str, str, str]] = (
        ("tracked", "tracked", ""),
        ("ATE m", "ate_rmse_m", ".4f"),
        ("RPE m", "rpe_trans_rmse_m", ".4f"),
        ("precision", "precision", ".3f"),
        ("recall", "recall", ".3f"),
        ("kept", "static_kept", ".3f"),
        ("ms", "judge_ms", ".2f"),
    )

    def _table(self) -> List[List[str]]:
        columns = [c for c in self._COLUMNS if c[1] == "tracked" or any(_known(run, c[1]) for run in self)]
        states = [["", "failed"]] if any(run.failure for run in self) else []
        rows = [["sequence", "pipeline"] + [title for title, _, _ in columns] + [""] * len(states)]
        for run in self:
            cells = [run.sequence, run.pipeline]
            for _, key, shape in columns:
                if key == "tracked":
                    cells.append(f"{run.tracked_frames}/{run.frames}")
                else:
                    cells.append(format(getattr(run, key), shape) if _known(run, key) else "-")
            rows.append(cells + [state[bool(run.failure)] for state in states])
        return rows

    def _notes(self) -> List[str]:
        """Each once, with its pipelines unless it is of all."""
        of: "dict[str, List[str]]" = {}
        for run in self:
            for note in (["failed: " + run.failure] if run.failure else []) + run.notes:
                names = of.setdefault(f"{run.sequence}: {note}", [])
                if run.pipeline not in names:
                    names.append(run.pipeline)
        every = len({run.pipeline for run in self})
        return [f"note: {note}" + (f" ({', '.join(names)})" if len(names) < every else "") for note, names in of.items()]

    def __str__(self) -> str:
        rows = self._table()
        wide = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        lines = [
            "  ".join(cell.ljust(w) if i < 2 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, wide))).rstrip()
            for row in rows
        ]
        notes = self._notes()
        return "\n".join(lines + ([""] + notes if notes else []))

    def markdown(self) -> str:
        """The table as Markdown."""
        head, *rows = self._table()
        lines = [head, ["---", "---"] + ["---:"] * (len(head) - 2)] + rows
        return "\n".join("| " + " | ".join(row) + " |" for row in lines)

    def _repr_html_(self) -> str:
        head, *rows = ("".join(f"<td>{cell}</td>" for cell in row) for row in self._table())
        return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


def _known(run: Run, key: str) -> bool:
    return not math.isnan(getattr(run, key))


@named_arguments
def compare(
    pipelines: Iterable[Source],
    on: Iterable[Union[str, _core.ExactScene, Sequence]],
    *,
    frames: Optional[int] = None,
) -> Comparison:
    """Runs every pipeline on every sequence or scene. Print the result.

    `pipelines`: presets, files, YAML text or filters.
    `on`: names of exact_scene_names(), ExactScene, Recording, render(...).

    Rows are told apart by names. Raises Error for two pipelines of one name, or a folder that is given twice.
    Filters of one class with other parameters, and folders of the same name, get longer names.
    """
    judged, places = list(pipelines), list(on)
    names, place_names = _pipeline_names(judged), _place_names(places)
    runs = Comparison()
    for place, place_name in zip(places, place_names):
        for pipeline, name in zip(judged, names):
            if isinstance(pipeline, Filter):
                pipeline.reset()
            if isinstance(place, (str, _core.ExactScene)):
                scene = _core.ExactScene(place) if isinstance(place, str) else place
                done = run_scene(pipeline, scene)
            else:
                done = run(pipeline, place, frames=frames)
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
