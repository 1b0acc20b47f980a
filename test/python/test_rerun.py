# SPDX-License-Identifier: MIT
"""What a run logs to rerun. Stand-ins for its module check names, shapes and types, as rerun 0.16 and 0.23 have them."""

import sys
from types import ModuleType

import numpy as np
import pytest

import dynfilter


class Logged:
    """An archetype: its arguments."""

    def __init__(self, kind, **values):
        self.kind, self.values = kind, values

    def compress(self, *, jpeg_quality):
        assert self.kind == "Image" and 1 <= jpeg_quality <= 100
        return self


class StandIn(ModuleType):
    def __init__(self, newer):
        super().__init__("rerun")
        self.logged, self.now, self.calls = [], {}, []
        self.ViewCoordinates = type("ViewCoordinates", (), {"RDF": Logged("ViewCoordinates")})
        setattr(self, "Scalars" if newer else "Scalar", lambda value: Logged("Scalar", value=float(value)))
        if newer:
            self.set_time = self._set_time
        else:
            self.set_time_sequence = lambda name, value: self.now.update({name: value})
            self.set_time_seconds = lambda name, value: self.now.update({name: value})

    def _set_time(self, name, *, sequence=None, timestamp=None):
        assert (sequence is None) != (timestamp is None)
        self.now[name] = timestamp if sequence is None else sequence

    def init(self, application, *, spawn=False):
        self.calls.append(("init", application, spawn))

    def save(self, path):
        self.calls.append(("save", path))

    def log(self, path, archetype, *, static=False):
        assert isinstance(archetype, Logged)
        self.logged.append((path, archetype, None if static else dict(self.now)))

    def AnnotationContext(self, labels):
        return Logged("AnnotationContext", labels={number: (name, colour) for number, name, colour in labels})

    def Image(self, image):
        assert image.dtype == np.uint8 and image.flags.c_contiguous and image.shape[2:] in ((3,), ())
        return Logged("Image", image=image.copy())

    def DepthImage(self, image, *, meter):
        return Logged("DepthImage", metres=image / meter)

    def Points2D(self, positions, *, class_ids, radii):
        assert positions.shape == (len(class_ids), 2) and class_ids.dtype == np.uint16
        return Logged("Points2D", positions=positions.copy(), class_ids=class_ids)

    def Boxes2D(self, *, mins, sizes, labels):
        assert mins.shape == sizes.shape == (len(labels), 2)
        return Logged("Boxes2D", mins=mins, sizes=sizes, labels=labels)

    def Pinhole(self, *, focal_length, principal_point, resolution):
        return Logged("Pinhole", focal_length=focal_length, resolution=resolution)

    def Transform3D(self, *, translation, mat3x3):
        assert np.shape(translation) == (3,) and np.shape(mat3x3) == (3, 3)
        return Logged("Transform3D", translation=np.array(translation), mat3x3=np.array(mat3x3))

    def LineStrips3D(self, strips, *, colors):
        (strip,) = strips
        assert strip.shape[1] == 3 and len(colors) == 1
        return Logged("LineStrips3D", strip=strip)

    def of(self, path):
        return [(archetype.values, time) for p, archetype, time in self.logged if p == path]


@pytest.fixture(params=[False, True], ids=["0.16", "0.23"])
def rerun(request, monkeypatch):
    module = StandIn(request.param)
    monkeypatch.setitem(sys.modules, "rerun", module)
    return module


def test_logs_the_run(rerun, rendered):
    seen = []
    plain = dynfilter.run("dynfilter", rendered, each=lambda frame, track: seen.append((frame, track.decision.copy())))
    result = dynfilter.to_rerun("dynfilter", rendered)
    assert rerun.calls == []  # the caller's recording
    assert result.ate_rmse_m == plain.ate_rmse_m and result.recall == plain.recall

    features = rerun.of("world/camera/image/features")
    assert len(features) == len(seen) == len(rendered)
    for (values, time), (frame, decision) in zip(features, seen):
        np.testing.assert_array_equal(values["class_ids"], decision)
        assert time == {"frame": frame.index, "time": frame.timestamp}
    (labels, static) = rerun.of("/")[0]
    assert static is None and labels["labels"][dynfilter.DYNAMIC][0] == "dynamic"
    rejected = [values["value"] for values, _ in rerun.of("features/dynamic")]
    assert rejected == [(decision == dynfilter.DYNAMIC).sum() for _, decision in seen]

    frame = seen[3][0]
    image = rerun.of("world/camera/image")[3][0]["image"]
    np.testing.assert_array_equal(image[:, :, 0], frame.colour[:, :, 2])  # red first
    metres = rerun.of("world/camera/depth")[3][0]["metres"]
    np.testing.assert_allclose(metres, frame.depth * frame.depth_unit_m)
    boxes = rerun.of("world/camera/image/boxes")[3][0]
    assert [tuple(m) + tuple(s) for m, s in zip(boxes["mins"], boxes["sizes"])] == [box.box for box in frame.boxes]
    (pinhole, _), = rerun.of("world/camera")[:1]
    assert pinhole["resolution"] == [640, 480]


def test_paths_are_in_one_frame(rerun, rendered):
    result = dynfilter.to_rerun("oracle", rendered)
    (estimate, _), = rerun.of("world/estimate")
    (truth, _), = rerun.of("world/truth")
    error_m = np.linalg.norm(estimate["strip"] - truth["strip"], axis=1)
    assert np.sqrt((error_m**2).mean()) == pytest.approx(result.ate_rmse_m, abs=1e-9)


def test_one_camera_has_a_unit_of_its_own(rerun):
    sequence = dynfilter.render("walking_xyz", frames=12)
    sequence.sensor = "mono"
    result = dynfilter.to_rerun("none", sequence)
    assert not rerun.of("world/estimate") and not rerun.of("world/camera/depth")
    assert len(rerun.of("paths/estimate")) == (1 if len(result.trajectory[0]) else 0)


def test_starts_a_recording(rerun, rendered, tmp_path):
    dynfilter.to_rerun("none", rendered, frames=2, save=tmp_path / "a.rrd")
    assert rerun.calls == [("init", "dynfilter", False), ("save", str(tmp_path / "a.rrd"))]
    dynfilter.to_rerun("none", rendered, frames=2, spawn=True, application="mine")
    assert rerun.calls[2:] == [("init", "mine", True)]
    assert len(rerun.of("world/camera/image")) == 4


def test_without_rerun(monkeypatch, rendered):
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(ModuleNotFoundError, match="rerun"):
        dynfilter.to_rerun("none", rendered)
