# SPDX-License-Identifier: MIT
import subprocess

import numpy as np
import pytest

import dynfilter


def test_exact_scene_has_its_geometry():
    """A point's pixel follows from its depth and the poses, where nothing moves."""
    scene = dynfilter.ExactScene("rigid")
    one, other = scene.frame(3), scene.frame(4)
    K = scene.camera.matrix
    rays = np.c_[one.keypoints, np.ones(len(one))] @ np.linalg.inv(K).T
    world = (rays * one.depth_m[:, None]) @ one.pose[:3, :3].T + one.pose[:3, 3]
    camera = (world - other.pose[:3, 3]) @ other.pose[:3, :3]
    pixels = camera @ K.T
    pixels = pixels[:, :2] / pixels[:, 2:]
    at = {point: i for i, point in enumerate(other.point)}
    both = [(i, at[p]) for i, p in enumerate(one.point) if p in at]
    assert len(both) > 200
    for i, j in both:
        np.testing.assert_allclose(pixels[i], other.keypoints[j], atol=0.01)


def test_exact_scene_options():
    names = dynfilter.exact_scene_names()
    assert "general" in names and len(names) == 10
    for name in names:
        dynfilter.ExactScene(name).frame(1)
    arguments = dynfilter.ExactScene("general", boxes=True, poses=True, descriptors=True, map_points=True).frame(3).arguments()
    for key in ("boxes", "pose", "descriptors", "map_point_ids", "map_points_m", "matches", "depth_m"):
        assert len(arguments[key]) > 0
    mono = dynfilter.ExactScene(mono=True, matches=False).frame(3).arguments()
    assert "depth_m" not in mono and "matches" not in mono
    same, seed = dynfilter.ExactScene(seed=7).frame(2), dynfilter.ExactScene(seed=8).frame(2)
    np.testing.assert_array_equal(dynfilter.ExactScene(seed=7).frame(2).keypoints, same.keypoints)
    assert not np.array_equal(same.keypoints, seed.keypoints)
    with pytest.raises(ValueError, match="preset: expected one of general, .*got `no`"):
        dynfilter.ExactScene("no")
    with pytest.raises(ValueError, match="camera_motion: expected one of none"):
        dynfilter.ExactScene(camera_motion="wild")
    with pytest.raises(ValueError, match="at_m: expected numbers of shape"):
        dynfilter.MovingBox(at_m=(1, 2))


def test_a_mover_is_dynamic_from_when_it_moves():
    scene = dynfilter.ExactScene(movers=[dynfilter.MovingBox(40, step_m=(0.05, 0, 0), still_until=4)])
    assert not scene.frame(4).dynamic.any()
    late = scene.frame(10)
    assert late.dynamic.any() and (late.label[late.dynamic] == 1).all() and late.static[late.label == 0].all()


def test_judge_needs_the_inputs():
    with pytest.raises(dynfilter.ConfigError, match="frame 8 of the scene has no boxes"):
        dynfilter.judge("semantic_box", dynfilter.ExactScene("general"))
    with pytest.raises(ValueError, match="unknown filter `nothing`; known filters: "):
        dynfilter.judge("nothing", dynfilter.ExactScene("general"))


def test_rendered_frames(rendered):
    frame = rendered[3]
    assert len(rendered) == 12 and [f.index for f in rendered] == list(range(12))
    assert frame.colour.shape == (480, 640, 3) and frame.colour.dtype == np.uint8
    assert frame.depth.shape == frame.grey.shape == (480, 640) and frame.depth.dtype == np.uint16
    assert set(np.unique(frame.truth)) <= {0, 128, 255} and frame.labels.max() > 0
    assert any(box.class_name == "person" for box in frame.boxes) and frame.mask is None
    stamps, poses = rendered.ground_truth()
    np.testing.assert_array_equal(poses[3], frame.pose)
    assert stamps[3] == frame.timestamp
    np.testing.assert_array_equal(rendered[-1].grey, rendered[11].grey)
    with pytest.raises(IndexError):
        rendered[12]
    with pytest.raises(dynfilter.ConfigError, match="walking_xyz"):
        dynfilter.render("no_such_scene")
    plain = dynfilter.render(frames=1, boxes=False, masks=True)[0]
    assert plain.boxes is None and plain.mask.any()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    import os

    path = tmp_path_factory.mktemp("sequence") / "walking"
    command = os.environ["DYNFILTER_COMMAND"]
    synth = [command, "synth", "walking_xyz", str(path), "--frames", "12", "--no-right"]
    subprocess.run(synth, check=True, capture_output=True)
    return path


def test_a_written_sequence_is_the_rendered_one(folder, rendered):
    sequence = dynfilter.Recording(folder)
    assert len(sequence) == 12 and sequence.name == "walking"
    for k in (0, 11):
        read, drawn = sequence[k], rendered[k]
        np.testing.assert_array_equal(read.depth, drawn.depth)
        np.testing.assert_array_equal(read.truth, drawn.truth)
        np.testing.assert_array_equal(read.labels, drawn.labels)
        assert read.depth_unit_m == pytest.approx(drawn.depth_unit_m)
        assert [b.class_name for b in read.boxes] == [b.class_name for b in drawn.boxes]
        assert read.timestamp == pytest.approx(drawn.timestamp, abs=1e-6)
    np.testing.assert_allclose(sequence.ground_truth()[1], rendered.ground_truth()[1], atol=1e-6)
    assert sequence[0].mask is not None
    bare = dynfilter.Recording(folder, detections=False, masks=False)
    assert bare[0].boxes is None and bare[0].mask is None


def test_a_mono_folder(rendered, tmp_path):
    """Images and a camera: the layout that any camera can write."""
    import cv2

    (tmp_path / "images").mkdir()
    for frame in rendered:
        cv2.imwrite(str(tmp_path / "images" / f"{frame.index:03}.png"), frame.grey)
    K = rendered.camera
    keys = {"fx": K.fx_px, "fy": K.fy_px, "cx": K.cx_px, "cy": K.cy_px, "width": K.width_px, "height": K.height_px}
    text = "".join(f"Camera.{key}: {value}\n" for key, value in keys.items())
    (tmp_path / "camera.yaml").write_text("%YAML:1.0\n---\n" + text)
    sequence = dynfilter.Recording(tmp_path, rate_hz=30)
    assert len(sequence) == 12 and sequence.sensor == "mono" and sequence.ground_truth() is None
    np.testing.assert_array_equal(sequence[5].grey, rendered[5].grey)
    assert sequence[5].depth is None and sequence[5].right is None
    assert dynfilter.run("none", sequence, frames=3).frames == 3


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(dynfilter.IoError, match="no such folder"):
        dynfilter.Recording(tmp_path / "none")
    with pytest.raises(OSError, match="none.txt"):
        dynfilter.read_trajectory(str(tmp_path / "none.txt"))


def test_the_odometry_is_that_of_the_command(folder, tmp_path, tool):
    import json

    for pipeline in ("dynfilter", "oracle"):
        out = tmp_path / pipeline
        run = [tool("DYNFILTER_COMMAND"), "run", str(folder), "--pipeline", pipeline, "--out", str(out)]
        subprocess.run(run, check=True, capture_output=True)
        expected = json.loads((out / "summary.json").read_text())
        ours = dynfilter.run(pipeline, dynfilter.Recording(folder))
        assert ours.frames == ours.tracked_frames == expected["tracked_frames"] == 12
        for key in ("ate_rmse_m", "precision", "recall", "static_kept"):
            assert getattr(ours, key) == pytest.approx(expected[key], abs=1e-12), key


def test_ate_and_rpe(tmp_path):
    """Known answers: a turn and a shift vanish by alignment, and one pose off by d gives d sqrt((n - 1) / n) / sqrt(n)."""
    n, d = 60, 0.3
    stamps = np.arange(n) / 10.0
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, 3] = np.random.default_rng(1).normal(size=(n, 3)) * 100  # the turn by one pose off is tiny
    turn = np.array([[0, -1, 0, 3], [1, 0, 0, 4], [0, 0, 1, 5], [0, 0, 0, 1.0]])
    moved = turn @ poses
    assert dynfilter.ate((stamps, poses), (stamps, moved)).rmse_m == pytest.approx(0, abs=1e-9)
    off = poses.copy()
    off[7, 2, 3] += d
    result = dynfilter.ate((stamps, poses), (stamps, off))
    assert result.pairs == n and result.rmse_m == pytest.approx(d * np.sqrt((n - 1) / n) / np.sqrt(n), rel=0.1)
    scaled = poses.copy()
    scaled[:, :3, 3] *= 2
    assert dynfilter.ate((stamps, poses), (stamps, scaled), scale=True).scale == pytest.approx(0.5)
    assert dynfilter.ate((stamps, poses), (stamps, scaled)).rmse_m > 10
    rpe = dynfilter.rpe((stamps, poses), (stamps, off))
    assert rpe.translation_m.max == pytest.approx(d) and rpe.rotation_deg.max == pytest.approx(0, abs=1e-5)
    dynfilter.write_trajectory(str(tmp_path / "t.txt"), (stamps, poses))
    read = dynfilter.read_trajectory(str(tmp_path / "t.txt"))
    np.testing.assert_allclose(read[1], poses, atol=1e-6)
    with pytest.raises(ValueError, match="estimate poses: expected numbers of shape"):
        dynfilter.ate((stamps, poses), (stamps, poses[:5]))
    with pytest.raises(ValueError, match="truth: expected \\(timestamps, poses\\)"):
        dynfilter.ate(poses, (stamps, poses))
    with pytest.raises(dynfilter.Error):
        dynfilter.ate((stamps, poses), (stamps + 1000, poses))


def test_compare(rendered):
    @__import__("dataclasses").dataclass
    class Nothing(dynfilter.Filter):
        def apply(self, evidence, votes):
            pass

    table = dynfilter.compare(["none", Nothing(), "epipolar"], ["general", dynfilter.ExactScene("rigid")])
    assert [(r.pipeline, r.sequence) for r in table] == [
        (p, s) for s in ("general", "exact scene") for p in ("none", "nothing", "epipolar")
    ]
    assert [r.recall for r in table[:3]] == [0, 0, 1] and np.isnan(table[3].recall)
    head, *rows = str(table).splitlines()
    assert head.split()[:2] == ["sequence", "pipeline"] and rows[6] == "" and rows[7].startswith("note: general: ")
    assert table.markdown().splitlines()[2].startswith("| general | none |")
    assert "<td>nothing</td>" in table._repr_html_()
    on_images = dynfilter.compare(["none", "oracle"], [rendered], frames=11)
    assert [r.frames for r in on_images] == [11, 11] and on_images[1].recall == 1


def test_own_sequences(rendered):
    """Frames of a user's own, without truth."""

    class Mine(dynfilter.Sequence):
        name, camera = "mine", rendered.camera

        def __len__(self):
            return 3

        def __getitem__(self, index):
            f = rendered[index]
            return dynfilter.Frame(index, f.timestamp, f.camera, f.colour, f.grey, f.depth, f.depth_unit_m)

    result = dynfilter.run("none", Mine())
    assert result.tracked_frames == 3 and np.isnan(result.ate_rmse_m) and np.isnan(result.recall)


def test_dense_map(rendered):
    """Points of the map lie where the depth image says, and the mover's are gone."""
    frame = rendered[0]
    labelled = frame.labels > 0
    options = dict(leaf_m=0.05, carve=False)
    whole, cut = dynfilter.StaticMap(**options), dynfilter.StaticMap(**options)
    given = dict(camera=frame.camera, depth=frame.depth, depth_unit_m=frame.depth_unit_m, bgr=frame.colour)
    assert whole.add(0, np.eye(4), **given).used
    assert cut.add(0, np.eye(4), moving_mask=labelled, **given).cut_pixels > 0.9 * (labelled & (frame.depth > 0)).sum()
    points, colours, classes = whole.cloud()
    assert points.shape == colours.shape and len(classes) in (0, len(points))
    fewer = cut.cloud()[0]
    assert 0 < len(fewer) < len(points)
    u = np.rint(points @ frame.camera.matrix.T / points[:, 2:])[:, :2].astype(int)
    inside = (u >= 0).all(axis=1) & (u[:, 0] < 640) & (u[:, 1] < 480)
    depth_m = frame.depth[u[inside, 1], u[inside, 0]] * frame.depth_unit_m
    assert np.median(np.abs(depth_m - points[inside, 2])) < 0.05  # a voxel
    assert cut.remove(0) and not cut.remove(0) and len(cut.cloud()[0]) == 0
    with pytest.raises(dynfilter.ConfigError, match="known keys: leaf_m"):
        dynfilter.StaticMap(leaf=1)
    with pytest.raises(dynfilter.ConfigError, match="leaf_m: expected"):
        dynfilter.StaticMap(leaf_m=-1)
