# SPDX-License-Identifier: MIT
"""The examples run, and say what their pages say."""

import re
import subprocess
import sys

import cv2
import pytest


@pytest.fixture
def example(root, tmp_path):
    def run(name, *arguments):
        program = [sys.executable, str(root / "examples/python" / name), *arguments]
        return subprocess.run(program, check=True, capture_output=True, text=True, cwd=tmp_path).stdout

    return run


def test_new_filter(example):
    text = example("new_filter.py")
    ate_m = {row.split()[1]: float(row.split()[3]) for row in text.splitlines() if row.startswith("walking_xyz ")}
    assert set(ate_m) == {"none", "median_flow", "both", "dynfilter"}
    assert ate_m["median_flow"] < 0.2 * ate_m["none"]


def test_pyslam_like(example):
    ate_m = {m[1]: float(m[2]) for m in re.finditer(r"^(\w+): ATE ([0-9.]+) m$", example("pyslam_like.py"), re.M)}
    assert ate_m["dynfilter"] < 0.2 * ate_m["none"]


def test_mask_for_any_host(example, tmp_path):
    assert "12 masks" in example("mask_for_any_host.py", "", "out", "255_drops")
    masks = [cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in sorted((tmp_path / "out").glob("*.png"))]
    assert len(masks) == 12 and masks[-1].shape == (480, 640) and 0 < (masks[-1] == 255).mean() < 0.5


def test_look_at_it(example, tmp_path):
    text = example("look_at_it.py", "pictures")
    assert "background_motion" in text
    for name in ("verdict", "suspicion", "map"):
        picture = cv2.imread(str(tmp_path / "pictures" / f"{name}.png"))
        assert picture is not None and picture.std() > 10
