# SPDX-License-Identifier: MIT
"""Sequences of frames: recordings in folders, and rendered ones."""

from __future__ import annotations

import bisect
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core
from .errors import IoError
from .keywords import named_arguments

Array = NDArray[Any]
Trajectory = Tuple[Array, Array]
"""(timestamps (n,) [s], poses (n, 4, 4) T_world_camera)"""

_SAME_STAMP_S = 5e-4
"""Files round timestamps."""


@dataclass
class Frame:
    """One frame. Images are (height, width) arrays, colour (height, width, 3) in the order blue, green, red."""

    index: int
    timestamp: float
    """[s]"""
    camera: _core.Camera
    colour: Array
    """uint8"""
    grey: Array
    """uint8"""
    depth: Optional[Array] = None
    """uint16, in units of `depth_unit_m`; 0: no depth"""
    depth_unit_m: float = 1.0
    right: Optional[Array] = None
    """uint8, the rectified image of the right camera of a stereo pair"""
    boxes: Optional[List[_core.Detection]] = None
    """None: no result came. An empty list: the detector found nothing."""
    boxes_frame_id: int = -1
    """Index of the frame that the boxes were computed on; -1: this one."""
    mask: Optional[Array] = None
    """uint8, 0: background"""
    pose: Optional[Array] = None
    """(4, 4), the true T_world_camera, where it is known per frame."""
    truth: Optional[Array] = None
    """uint8: 0 static, 255 dynamic, 128 don't care; rendered sequences only."""
    labels: Optional[Array] = None
    """uint8: 0 static, k: mover k, moving or not; rendered sequences only."""

    def arguments(self) -> Dict[str, Any]:
        """What Pipeline.before_pose() takes of it, beside the keypoints."""
        out: Dict[str, Any] = {"timestamp": self.timestamp, "frame_id": self.index, "grey": self.grey}
        out["camera"] = self.camera
        if self.depth is not None:
            out.update(depth=self.depth, depth_unit_m=self.depth_unit_m)
        if self.boxes is not None:
            out.update(boxes=self.boxes, boxes_frame_id=None if self.boxes_frame_id < 0 else self.boxes_frame_id)
        if self.mask is not None:
            out["mask"] = self.mask
        return out


class Sequence:
    """What compare() and run() take. Derive from it to bring frames of your own."""

    name: str
    camera: _core.Camera
    sensor: str = "rgbd"
    """rgbd, stereo or mono: what the odometry uses of a frame."""
    scene: Optional[str] = None
    """Sequences of one scene are pooled in the tables of a comparison; None: the sequence is its own scene."""

    def __len__(self) -> int:
        raise NotImplementedError

    def __getitem__(self, index: int) -> Frame:
        """Frame `index`; IndexError beyond the last one."""
        raise NotImplementedError

    def __iter__(self) -> Iterator[Frame]:
        return (self[i] for i in range(len(self)))

    def ground_truth(self) -> Optional[Trajectory]:
        """The true poses, or None."""
        return None


class Recording(Sequence):
    """A video, a camera ("camera:0"), images ("frames/*.png"), or a folder as downloaded.

    Folders are TUM RGB-D, Bonn, KITTI odometry, EuRoC, images, or of `synth`. Iterate over a video: it is decoded
    once, one frame at a time. Its length is what the file says. Without a camera the focal length is guessed.
    Boxes come from `detections.txt`, else from the first `detections_*.txt`; masks from `masks/`.
    `detections`, `masks`: other files; False: none. `camera`: instead of the folder's.
    `rate_hz`: of images without timestamps. `scale`: images are made smaller by this, above 0 to 1.
    Raises IoError.
    """

    @named_arguments
    def __init__(
        self,
        folder: Union[str, "os.PathLike[str]"],
        *,
        detections: Union[None, bool, str, "os.PathLike[str]"] = None,
        masks: Union[None, bool, str, "os.PathLike[str]"] = None,
        camera: Optional[_core.Camera] = None,
        rate_hz: Optional[float] = None,
        scale: float = 1,
    ) -> None:
        self.folder = Path(folder)
        self._reader = _core._Reader(os.fspath(folder), camera, rate_hz, scale)
        self.sensor = self._reader.sensor
        self.camera = self._reader.camera
        self.name = self._reader.name
        self.scene = self._reader.scene or None
        self.is_stream: bool = self._reader.is_stream
        self._scale = scale
        self._boxes = _boxes(_chosen(detections, _detections_in(self.folder)))
        self._masks = _chosen(masks, self.folder / "masks")

    def __len__(self) -> int:
        return len(self._reader)

    def __getitem__(self, index: int) -> Frame:
        return self._frame(index % len(self), self._reader.load(index))

    def __iter__(self) -> Iterator[Frame]:
        for i in range(len(self)):
            loaded = self._reader.read(i)
            if loaded is None:
                return
            yield self._frame(i, loaded)

    def _frame(self, i: int, loaded: Dict[str, Any]) -> Frame:
        boxes = self._boxes.at(loaded["timestamp"]) if self._boxes else None
        if boxes and self._scale != 1:
            boxes = [_scaled(box, self._scale) for box in boxes]
        return Frame(index=i, camera=self.camera, boxes=boxes, mask=self._mask(i), **loaded)

    @property
    def camera_is_guessed(self) -> bool:
        """Nothing tells the camera: good for verdicts, not for poses."""
        return self._reader.camera_is_guessed

    @property
    def notes(self) -> List[str]:
        """What was skipped or guessed, of a video so far."""
        return self._reader.notes

    def ground_truth(self) -> Optional[Trajectory]:
        """The poses of the folder; None if it has none."""
        return self._reader.ground_truth()

    def _mask(self, i: int) -> Optional[Array]:
        if self._masks is None:
            return None
        file = self._masks / f"{self._reader.image_name(i)}.png"
        return _core._read_mask(str(file)) if file.is_file() else None


class RenderedSequence(Sequence):
    """Frames of a rendered scene, drawn when they are asked for. See render()."""

    def __init__(self, renderer: _core._Renderer, name: str, scene: str, boxes: bool, masks: bool) -> None:
        self._renderer, self._gives = renderer, (boxes, masks)
        self.camera = renderer.camera
        self.name = name
        self.scene = scene

    def __len__(self) -> int:
        return len(self._renderer)

    def __getitem__(self, index: int) -> Frame:
        drawn = self._renderer.load(index)
        boxes, masks = self._gives
        if not boxes:
            drawn.pop("boxes", None), drawn.pop("boxes_frame_id", None)
        if not masks:
            drawn.pop("mask")
        return Frame(index=index % len(self), camera=self.camera, **drawn)

    def ground_truth(self) -> Trajectory:
        """The true poses of all frames."""
        frames = range(len(self))
        stamps = np.array([self._renderer.timestamp(i) for i in frames])
        return stamps, np.stack([self._renderer.pose(i) for i in frames])


_RENDER_DEFAULTS: Dict[str, Any] = dict(rate_hz=None, boxes=True, masks=False, late_boxes=0, motion_blur=False)
_RENDER_DEFAULTS.update(exposure_variation=False, image_noise=1.6, perfect_depth=False)
"""Scenes that differ in these are not pooled."""


@named_arguments
def render(
    scene: str = "walking_xyz",
    *,
    frames: int = 200,
    seed: int = 1,
    rate_hz: Optional[float] = None,
    boxes: bool = True,
    masks: bool = False,
    late_boxes: int = 0,
    motion_blur: bool = False,
    exposure_variation: bool = False,
    image_noise: float = 1.6,
    perfect_depth: bool = False,
    right_images: bool = False,
) -> RenderedSequence:
    """A rendered RGB-D sequence with labels; scene_names() lists the scenes.

    `boxes`: of a simulated detector; `late_boxes`: each result is of that many frames before.
    `masks`: exact masks of people. `image_noise`: grey levels.
    `rate_hz`: None: that of the scene's camera. `right_images`: of a stereo camera, which run() then uses.
    A frame takes about 50 ms. Raises ConfigError for an unknown scene.
    """
    renderer = _core._Renderer(
        scene,
        frames,
        seed,
        rate_hz,
        motion_blur,
        exposure_variation,
        image_noise,
        perfect_depth,
        late_boxes,
        right_images,
    )
    options: Dict[str, Any] = dict(rate_hz=rate_hz, boxes=boxes, masks=masks, late_boxes=late_boxes, motion_blur=motion_blur)
    options.update(exposure_variation=exposure_variation, image_noise=image_noise, perfect_depth=perfect_depth)
    changed = [f", {name}={value}" for name, value in options.items() if value != _RENDER_DEFAULTS[name]]
    name = f"{scene}_{seed}" if seed != 1 else scene
    sequence = RenderedSequence(renderer, name, scene + "".join(changed), boxes, masks)
    sequence.sensor = "stereo" if right_images else "rgbd"
    return sequence


class _boxes:
    """Boxes of a file by timestamp. False without a file."""

    def __init__(self, path: Optional[Path]) -> None:
        self._images = _core.read_detections(str(path)) if path else []
        self._stamps = [stamp for stamp, _ in self._images]

    def __bool__(self) -> bool:
        return bool(self._images)

    def at(self, timestamp: float) -> Optional[List[_core.Detection]]:
        i = bisect.bisect_left(self._stamps, timestamp - _SAME_STAMP_S)
        if i < len(self._stamps) and self._stamps[i] <= timestamp + _SAME_STAMP_S:
            return self._images[i][1]
        return None


def _scaled(d: _core.Detection, scale: float) -> _core.Detection:
    box = [scale * side for side in d.box]
    return _core.Detection(box, d.class_name, d.score, class_id=d.class_id, track_id=d.track_id)


def _detections_in(folder: Path) -> Optional[Path]:
    if (folder / "detections.txt").is_file():
        return folder / "detections.txt"
    return next(iter(sorted(folder.glob("detections_*.txt"))), None)


def _chosen(given: Union[None, bool, str, "os.PathLike[str]"], own: Optional[Path]) -> Optional[Path]:
    if given is False:
        return None
    if given is None or given is True:
        return own if own is not None and own.exists() else None
    path = Path(given)
    if not path.exists():
        raise IoError(f"{path}: no such file or folder")
    return path
