# SPDX-License-Identifier: MIT
"""The same verdicts as from C++, bit for bit."""

import subprocess

import numpy as np

import dynfilter

GRID_PX = 16


def line(pipeline, scene, k, verdict):
    decisions = "".join(map(str, verdict.decision))
    suspicions = "".join(f"{bits:08x}" for bits in verdict.suspicion.view(np.uint32))
    reasons = "".join(f"{bits:x}." for bits in verdict.reason_bits)
    return f"{pipeline} {scene} {k} {decisions} {suspicions} {reasons}"


def exact_lines(name, scene_name, scene):
    pipeline = dynfilter.Pipeline(name)
    return [line(name, scene_name, k, pipeline.before_pose(**scene.frame(k).arguments())) for k in range(8)]


def rendered_lines(name, frames):
    pipeline = dynfilter.Pipeline(name)
    height, width = frames[0].grey.shape
    y, x = np.mgrid[GRID_PX : height - GRID_PX : GRID_PX, GRID_PX : width - GRID_PX : GRID_PX]
    lattice = np.stack([x.ravel(), y.ravel()], axis=1)  # integers: converted
    return [line(name, "rendered", k, pipeline.before_pose(lattice, **f.arguments())) for k, f in enumerate(frames)]


def test_all_presets(tool):
    names = [name for name in dynfilter.presets() if name != "oracle"]
    expected = subprocess.run([tool("VERDICTS_PROGRAM"), *names], check=True, capture_output=True, text=True)
    noisy = dynfilter.ExactScene("general", pixel_noise_px=0.5, depth_noise_m=0.0014)
    full = dynfilter.ExactScene(
        "several_movers", pixel_noise_px=0.3, mismatches=0.05, poses=True, boxes=True, late_boxes=1,
        descriptors=True, map_points=True,
    )  # fmt: skip
    frames = list(dynfilter.render(frames=3))
    lines = []
    for name in names:
        lines += exact_lines(name, "noisy", noisy) + exact_lines(name, "full", full) + rendered_lines(name, frames)
    assert lines == expected.stdout.splitlines()
    rejected = [text for text in lines if "2" in text.split()[3]]
    assert len(rejected) > len(lines) / 4  # the comparison is about something
