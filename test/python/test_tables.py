# SPDX-License-Identifier: MIT
"""Comparisons as tables for a paper and as a page: the figures are those of the runs, and of the command."""

import csv
import io
import itertools
import json
import math
import os
import statistics
import subprocess
import sys

import pytest

import dynfilter
from dynfilter import _core


def run(pipeline, variant, ate_m, **more):
    figures = dict(scene="walking", variant=variant, frames=10, tracked_frames=9, ate_rmse_m=ate_m, recall=0.5)
    return dynfilter.Run(pipeline, "walking_3", trajectory=([], []), **{**figures, **more})


@pytest.fixture
def table():
    """`half_one` has half the error of `one` in each of six runs."""
    return dynfilter.Comparison(
        run(name, f"from {k}", 0.01 * k * factor) for name, factor in (("one", 1), ("half_one", 0.5)) for k in range(1, 7)
    )


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_csv_has_the_statistics_of_the_runs(table):
    one, half = rows_of(table.to_csv())
    errors = [0.01 * k for k in range(1, 7)]
    for key, wanted in [
        ("ate_median_m", statistics.median(errors)),
        ("ate_worst_m", max(errors)),
        ("ate_mean_m", statistics.mean(errors)),
        ("ate_std_m", statistics.stdev(errors)),
    ]:
        assert float(one[key]) == pytest.approx(wanted) and float(half[key]) == pytest.approx(wanted / 2)
    assert (one["sequence"], one["runs"], one["tracked_percent"], one["alignment"]) == ("walking", "6", "90", "SE(3)")
    assert (one["p_value"], half["p_value"], half["reference"], half["pairs"]) == ("", "0.03125", "one", "6")
    assert half["best"].split() == ["ate_median_m", "ate_worst_m", "ate_mean_m", "ate_std_m"]
    assert one["version"] == dynfilter.__version__ and one["machine"]
    table.reference = "half_one"
    assert [row["pairs"] for row in rows_of(table.to_csv())] == ["6", "0"]


def test_latex_and_markdown(table, tmp_path):
    latex = table.to_latex(tmp_path / "table.tex")
    assert (tmp_path / "table.tex").read_text(encoding="utf-8") == latex
    assert r"half\_one & 90.0 & \textbf{0.0175} & \textbf{0.0300}" in latex and r"0.031\rlap{$^{*}$}" in latex
    assert "after SE(3) alignment" in latex and "Wilcoxon signed-rank test" in latex
    markdown = table.to_markdown(str(tmp_path / "table.md"))
    assert "| walking | half\\_one | 90.0 | **0.0175** |" in markdown
    assert (tmp_path / "table.md").read_text(encoding="utf-8") == markdown
    for write in (table.to_latex, table.to_markdown, table.to_csv):
        with pytest.raises(dynfilter.IoError, match="no_such/x: cannot be written: No such file or directory"):
            write(tmp_path / "no_such" / "x")


def test_dataframe(table, monkeypatch):
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "pandas", None)
        with pytest.raises(ImportError, match=r"to_dataframe\(\) needs pandas"):
            table.to_dataframe()
    pytest.importorskip("pandas")
    frame = table.to_dataframe()
    assert list(frame.columns) == list(rows_of(table.to_csv())[0])
    assert list(frame.pipeline) == ["one", "half_one"] and frame.ate_worst_m[0] == pytest.approx(0.06)
    assert math.isnan(frame.p_value[0])
    table.append(run("none", "", math.nan))
    assert list(table.to_dataframe().pipeline) == ["one", "half_one", "none"]  # a name, not a missing value


def enumerated_p(differences):
    """The definition: all signs of the ranks are equally likely."""
    d = [x for x in differences if x != 0]
    ranks = [sum(abs(y) < abs(x) for y in d) + (sum(abs(y) == abs(x) for y in d) + 1) / 2 for x in d]

    def smaller(signs):
        positive = sum(rank for rank, sign in zip(ranks, signs) if sign)
        return min(positive, sum(ranks) - positive)

    seen = smaller([x > 0 for x in d])
    all_signs = list(itertools.product((False, True), repeat=len(d)))
    return sum(smaller(signs) <= seen for signs in all_signs) / len(all_signs)


def test_signed_ranks():
    for d in ([1.0], [1, -2, 3], [1, 1, -1, 2, 0], [5, 4, -3, 2, 2, 2, -1, 6], [1, 2, 3, 4, 5, 6, 7]):
        assert _core._signed_rank_p(d) == pytest.approx(enumerated_p(d), rel=1e-12)
    assert math.isnan(_core._signed_rank_p([0.0]))


def test_errors(table):
    with pytest.raises(dynfilter.Error, match="reference: `tow` is none of the pipelines: none, epipolar"):
        dynfilter.compare(["none", "epipolar"], ["general"], reference="tow")
    table.reference = "tow"
    with pytest.raises(dynfilter.Error, match="the reference `tow` is none of the pipelines that are compared"):
        table.to_latex()
    with pytest.raises(dynfilter.Error, match="report: no run is on a sequence"):
        dynfilter.compare(["none"], ["general"]).report("never.html")


def test_exact_scenes_have_no_trajectory():
    latex = dynfilter.compare(["none", "epipolar"], ["general"]).to_latex()
    assert "ATE" not in latex and "Tracked" not in latex and "epipolar & " in latex


@pytest.fixture(scope="module")
def walking(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables") / "walk"
    synth = [os.environ["DYNFILTER_COMMAND"], "synth", "walking_static", str(folder), "--frames", "13", "--no-right"]
    subprocess.run([*synth, "--seed", "3"], check=True, capture_output=True)
    return folder


def test_variants_are_those_of_the_command(walking):
    """Frames, figures and what the table says of them."""
    command = [os.environ["DYNFILTER_COMMAND"], "compare", str(walking), "--pipelines", "none,oracle", "--variants"]
    theirs = json.loads(subprocess.run(command + ["--json"], check=True, capture_output=True).stdout)
    ours = dynfilter.compare(["none", "oracle"], [dynfilter.Recording(walking)], variants=True, pictures=False)
    assert [(r.pipeline, r.variant) for r in ours] == [(r["pipeline"], r["variant"]) for r in theirs["rows"]]
    for own, other in zip(ours, theirs["rows"]):
        assert (own.scene, own.frames, own.tracked_frames) == ("walking_static", other["frames"], other["tracked_frames"])
        for key in ("ate_rmse_m", "recall", "static_kept", "first_s", "last_s"):
            wanted = math.nan if other[key] is None else other[key]
            assert getattr(own, key) == pytest.approx(wanted, abs=1e-12, nan_ok=True), (key, own)
        assert own.cpu_ms > 0
    keys = dict(ate_rmse_m="ate_median_m", ate_rmse_max_m="ate_worst_m", ate_rmse_mean_m="ate_mean_m", pairs="pairs")
    keys.update(ate_rmse_std_m="ate_std_m", p_value="p_value", recall="recall", reference="reference", runs="runs")
    for own, other in zip(rows_of(ours.to_csv()), theirs["medians"]):
        for key, column in keys.items():
            wanted = "" if other[key] is None else other[key]
            assert own[column] == str(wanted) or float(own[column]) == pytest.approx(wanted, abs=1e-12), key


def test_report(walking, tmp_path):
    """The page has all runs, under the names of the table."""
    ours = dynfilter.compare(["none", "oracle"], [dynfilter.Recording(walking)], frames=6)
    ours[1].pipeline = "</script>"
    text = open(ours.report(tmp_path / "page.html"), encoding="utf-8").read()
    data = json.loads(text.split('<script type="application/json" id="data">')[1].split("</script>")[0])
    assert [(r["summary"]["pipeline"], r["variant"]) for r in data["runs"]] == [(r.pipeline, r.variant) for r in ours]
    for own, shown in zip(ours, data["runs"]):
        assert shown["summary"]["ate_rmse_m"] == pytest.approx(own.ate_rmse_m)
        assert len(shown["frames"]["index"]) == len(shown["pictures"]) == own.frames == 6
        known = [e for e in shown["frames"]["error_m"] if e is not None]
        assert math.sqrt(sum(e * e for e in known) / len(known)) == pytest.approx(own.ate_rmse_m, abs=1e-5)
    assert [m["pipeline"] for m in data["medians"]] == ["none", "</script>"]
    with pytest.raises(dynfilter.Error, match="report: no run is on a sequence"):
        dynfilter.compare(["none"], [dynfilter.Recording(walking)], frames=2, pictures=False).report(tmp_path / "no.html")


def test_seeds_are_pooled_and_other_conditions_are_not():
    on = [dynfilter.render("walking_static", frames=4, seed=seed) for seed in (1, 2)]
    on.append(dynfilter.render("walking_static", frames=4, boxes=False))
    rows = rows_of(dynfilter.compare(["none"], on, pictures=False).to_csv())
    assert [(row["sequence"], row["runs"]) for row in rows] == [("walking_static", "2"), ("walking_static, boxes=False", "1")]


def test_played_frames(rendered):
    late = dynfilter.render("walking_xyz", frames=6, late_boxes=2)
    seen = []
    dynfilter.run("none", late, start=1, each=lambda frame, _: seen.append((frame.index, frame.boxes_frame_id)))
    # Boxes of frame 0 were left out with it; those of frame k came with frame k + 2, counted from the start.
    assert seen == [(1, -1), (2, -1), (3, 0), (4, 1), (5, 2)]
    seen.clear()
    dynfilter.run("none", late, reverse=True, frames=3, each=lambda frame, _: seen.append((frame.index, frame.boxes)))
    assert seen == [(5, None), (4, None), (3, None)]  # late boxes are of frames to come
    with pytest.raises(dynfilter.Error, match="start 12: the sequence has only 12 frames"):
        dynfilter.run("none", rendered, start=12)
