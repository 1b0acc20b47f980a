# SPDX-License-Identifier: MIT
"""Each row of a comparison is that of its pipeline on its sequence, run alone, and that of the command."""

import json
import math
import os
import shutil
import subprocess
from dataclasses import dataclass

import numpy as np
import pytest

import dynfilter

FIGURES = ["ate_rmse_m", "rpe_trans_rmse_m", "precision", "recall", "static_kept"]
NO_LABELS = "has no label images, which `oracle` needs: choose another pipeline"


@dataclass
class TooNear(dynfilter.Filter, needs="depth"):
    min_depth_m: float = dynfilter.param(1.0, unit="m", min=0, max=10)

    def apply(self, evidence, votes):
        votes.dynamic(evidence.depths_m < self.min_depth_m)


@dataclass
class Broken(dynfilter.Filter):
    def apply(self, evidence, votes):
        raise RuntimeError("it melted")


def text(name, stages):
    return f"%YAML:1.0\n---\npipeline:\n  name: {name}\n  before_pose:\n{stages}"


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """Two sequences in folders of one name, and pipelines in files of one name."""
    root = tmp_path_factory.mktemp("rows")
    command = os.environ["DYNFILTER_COMMAND"]
    for folder, scene in (("a", "walking_static"), ("b", "moving_box")):
        (root / folder).mkdir()
        run = [command, "synth", scene, str(root / folder / "desk"), "--frames", "12", "--no-right", "--seed", "3"]
        subprocess.run(run, check=True, capture_output=True)
    (root / "a/p.yaml").write_text(text("boxes", "    - semantic_box: { role: reject }\n"))
    (root / "b/p.yaml").write_text(text("flow", "    - epipolar: { max_distance_px: 1.0 }\n"))
    shutil.copytree(root / "b/desk", root / "bare")
    for folder in ("labels", "dynamic"):
        shutil.rmtree(root / "bare" / folder)
    return root


def same(one, other):
    return all(
        getattr(one, key) == getattr(other, key) or (math.isnan(getattr(one, key)) and math.isnan(getattr(other, key)))
        for key in FIGURES + ["frames", "tracked_frames"]
    ) and one.notes == other.notes and one.failure == other.failure


def test_rows_on_sequences(places):
    pipelines = ["none", "oracle", places / "a/p.yaml", places / "b/p.yaml", TooNear(), TooNear(min_depth_m=2.0)]
    names = ["none", "oracle", "boxes", "flow", "TooNear(min_depth_m=1.0)", "TooNear(min_depth_m=2.0)"]
    folders = [places / "a/desk", places / "b/desk"]
    rows = dynfilter.compare(pipelines, [dynfilter.Recording(folder) for folder in folders], pictures=False)
    assert [(r.sequence, r.pipeline) for r in rows] == [(s, p) for s in ("a/desk", "b/desk") for p in names]
    ran = [(p, folder) for folder in folders for p in pipelines]
    for row, (pipeline, folder) in list(zip(rows, ran))[:: 1 if "DYNFILTER_LONG_TESTS" in os.environ else 5]:
        assert same(row, dynfilter.run(pipeline, dynfilter.Recording(folder))), (row, folder)
    for first in (0, len(pipelines)):  # a comparison of equal figures would show nothing
        assert len({row.ate_rmse_m for row in rows[first : first + 4]}) >= 3
    # The command's.
    command = [os.environ["DYNFILTER_COMMAND"], "compare", *map(str, folders), "--json", "--pipelines"]
    command.append(",".join(["none", "oracle", str(pipelines[2]), str(pipelines[3])]))
    theirs = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["rows"]
    ours = [row for row in rows if not row.pipeline.startswith("TooNear")]
    assert [(r["sequence"], r["pipeline"]) for r in theirs] == [(r.sequence, r.pipeline) for r in ours]
    for own, other in zip(ours, theirs):
        for key in FIGURES:
            expected = math.nan if other[key] is None else other[key]
            assert getattr(own, key) == pytest.approx(expected, abs=1e-12, nan_ok=True), (key, own)


def test_rows_on_exact_scenes():
    scenes = ["general", dynfilter.ExactScene("rigid"), dynfilter.ExactScene("general", seed=5)]
    rows = dynfilter.compare(["none", TooNear(), "epipolar"], scenes)
    assert [r.sequence for r in rows[::3]] == ["general", "exact scene (1)", "exact scene (2)"]
    for k, row in enumerate(rows):
        scene = scenes[k // 3] if k >= 3 else dynfilter.ExactScene("general")
        assert same(row, dynfilter.run_scene(["none", TooNear(), "epipolar"][k % 3], scene)), row


def test_rows_that_could_not_be_told_apart(places):
    desk = dynfilter.Recording(places / "a/desk")
    box = "    - semantic_box: { role: reject }\n"
    for pipelines, reason in [
        (["none", "none"], "`none` is given twice"),
        ([text("p", box), text("p", "    - epipolar\n")], "are both named `p`: their rows could not be told apart"),
        ([str(places / "a/p.yaml"), text("boxes", "    - epipolar\n")], "are both named `boxes`"),
        ([TooNear(), TooNear()], "is given twice"),
    ]:
        with pytest.raises(dynfilter.Error, match=reason):
            dynfilter.compare(pipelines, [desk])
        with pytest.raises(dynfilter.Error, match=reason):
            dynfilter.compare(pipelines, ["general"])
    for places_, reason in [
        ([desk, desk], "`desk` is given twice"),
        ([desk, dynfilter.Recording(places / "b/../a/desk")], "are one folder"),
    ]:
        with pytest.raises(dynfilter.Error, match=reason):
            dynfilter.compare(["none"], places_)


def test_no_oracle_without_labels(places, rendered):
    """The same line as the command's."""
    bare = dynfilter.Recording(places / "bare")
    command = [os.environ["DYNFILTER_COMMAND"], "run", str(places / "bare"), "--pipeline", "oracle"]
    assert NO_LABELS in subprocess.run(command, capture_output=True, text=True).stderr
    within = text("mine", "    - any:\n        - oracle\n")
    for pipeline in ("oracle", within):
        with pytest.raises(dynfilter.IoError, match=f"{places / 'bare'}: {NO_LABELS}"):
            dynfilter.run(pipeline, bare)
        with pytest.raises(dynfilter.IoError, match=NO_LABELS):
            dynfilter.compare(["none", pipeline], [bare])
        odometry = dynfilter.Odometry(bare.camera, pipeline)
        with pytest.raises(dynfilter.IoError, match=f"frame 0: {NO_LABELS}"):
            odometry.process(bare[0].grey, timestamp=0.0, depth=bare[0].depth, depth_unit_m=bare[0].depth_unit_m)
        with pytest.raises(dynfilter.ConfigError, match="oracle"):
            dynfilter.compare([pipeline], ["general"])

    class Some(dynfilter.Sequence):
        """Labels on the first frames only."""

        name, camera = "some", rendered.camera

        def __len__(self):
            return 4

        def __getitem__(self, index):
            frame = rendered[index]
            frame.labels = frame.labels if index < 2 else None
            return frame

    with pytest.raises(dynfilter.IoError, match=f"some: {NO_LABELS}"):
        dynfilter.run("oracle", Some())


def test_a_filter_that_raises_gives_no_row(places):
    for on in ([dynfilter.Recording(places / "a/desk")], ["general"]):
        with pytest.raises(RuntimeError, match="it melted"):
            dynfilter.compare(["none", Broken()], on)


def test_missing_inputs_are_said(places):
    boxes = text("boxes", "    - semantic_box: { role: reject }\n")
    bare = dynfilter.Recording(places / "a/desk", detections=False, masks=False)
    for on in (bare, "general"):
        none, row = dynfilter.compare(["none", boxes], [on], frames=5)
        assert none.notes == [] and not row.failure
        assert "every feature of every frame is unknown" in row.notes[0]
        assert any("semantic_box: skipped: no boxes" in note or "semantic_box: no boxes" in note for note in row.notes)
        table = str(dynfilter.compare(["none", boxes], [on], frames=5))
        assert "note: " in table and "every feature of every frame is unknown" in table and "(boxes)" in table


def test_a_failed_run_shows_no_figures():
    run = dynfilter.Run("p", "s", 5, 5, failure="x failed on all of 5 frames", notes=[])
    table = dynfilter.Comparison([dynfilter.Run("none", "s", 5, 5, ate_rmse_m=0.1), run])
    assert "failed" in table.markdown().splitlines()[-1] and "note: s: failed: x failed" in str(table)
    assert np.isnan(run.ate_rmse_m)
