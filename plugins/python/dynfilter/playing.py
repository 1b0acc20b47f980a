# SPDX-License-Identifier: MIT
"""The order in which a run plays the frames of a sequence, and what sensors tell of the motion between them."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Dict, Iterator, Union

import numpy as np

from . import _core
from .errors import Error
from .sequences import Frame, Recording, Sequence, Trajectory

File = Union[None, str, "os.PathLike[str]"]


def played(sequence: Sequence, start: int, reverse: bool) -> Iterator[Frame]:
    """The frames from `start` on, or those of the reversed sequence.

    Frames that boxes are of are counted in the order of playing. In reverse, late results are of frames to come:
    they are left out.
    """
    n = len(sequence)
    if not 0 <= start < max(1, n):
        raise Error(f"start {start}: the sequence has only {n} frames")
    if not reverse and start == 0:
        yield from sequence
        return
    if isinstance(sequence, Recording) and sequence.is_stream:
        raise Error(f"{sequence.folder} is decoded forwards and from its start only; extract its images to a folder")
    order = list(range(n - 1, -1, -1) if reverse else range(n))[start:]
    for k, i in enumerate(order):
        frame = sequence[i]
        if frame.boxes_frame_id >= 0:
            of = n - 1 - frame.boxes_frame_id - start if reverse else frame.boxes_frame_id - start
            frame = replace(frame, boxes_frame_id=of) if 0 <= of <= k else replace(frame, boxes=None, boxes_frame_id=-1)
        yield frame


def motion_priors(sequence: Sequence, imu: File, wheel_odometry: File) -> _core._MotionPriors:
    """The priors of a run, made of the recording's own stamps."""
    files = _file("imu", imu), _file("wheel_odometry", wheel_odometry)
    folder = str(sequence.folder) if isinstance(sequence, Recording) else ""
    if files[0] == "auto" and not folder:
        raise Error(f"imu: `auto` is the gyroscope of a recording's folder, and `{sequence.name}` has none: give a file")
    return _core._MotionPriors(folder, *files)


def _file(argument: str, given: File) -> str:
    """"" for None."""
    if given is None:
        return ""
    if not isinstance(given, (str, os.PathLike)):
        raise ValueError(f"{argument}: expected a file, got a {type(given).__name__}")
    return os.fspath(given)


def own_stamps(trajectory: Trajectory, own: Dict[float, float]) -> Trajectory:
    """With the sequence's stamps, in their order."""
    stamps = np.array([own[stamp] for stamp in trajectory[0]])
    order = np.argsort(stamps, kind="stable")
    return stamps[order], trajectory[1][order]
