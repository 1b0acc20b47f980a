#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A notebook as a script: run it cell by cell (VS Code, Jupytext, Spyder) or whole. Writes its pictures to OUT.

    python3 examples/python/look_at_it.py [OUT]
"""

# %% What is installed
import sys
from pathlib import Path

import cv2
import numpy as np

import dynfilter

out = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "look_at_it")
out.mkdir(parents=True, exist_ok=True)
print(f"dynfilter {dynfilter.__version__}: {len(dynfilter.presets())} presets, {len(dynfilter.filter_cards())} filters")

# %% The card of a filter: what it needs, its parameters
print(next(card for card in dynfilter.filter_cards() if card.name == "epipolar"))

# %% A rendered sequence, and the verdict on its last frame
sequence = dynfilter.render("walking_xyz", frames=12)
pipeline = dynfilter.Pipeline("dynfilter")
for frame in sequence:
    corners = cv2.goodFeaturesToTrack(frame.grey, 1000, 0.003, 8).reshape(-1, 2)
    verdict = pipeline.before_pose(corners, **frame.arguments())
print(verdict.report)
cv2.imwrite(str(out / "verdict.png"), verdict.draw(frame.colour))

# %% Who is suspected how much: a picture of the suspicion
heat = np.zeros(frame.grey.shape, np.uint8)
for (x, y), suspicion in zip(corners, verdict.suspicion):
    cv2.circle(heat, (int(x), int(y)), 6, int(255 * suspicion), cv2.FILLED)
cv2.imwrite(str(out / "suspicion.png"), cv2.applyColorMap(heat, cv2.COLORMAP_INFERNO))

# %% Why: features per stage
for stage in verdict.report.stages:
    print(f"{stage.name:20} judged {stage.judged:4}  dynamic {stage.dynamic:4}  {stage.time_ms:.2f} ms  {stage.note}")

# %% The static map of three keyframes, seen from above
world = dynfilter.StaticMap(leaf_m=0.03)
for k in (0, 5, 10):
    key = sequence[k]
    assert key.pose is not None and key.depth is not None  # rendered frames have both
    world.add(
        k,
        key.pose,
        camera=key.camera,
        depth=key.depth,
        depth_unit_m=key.depth_unit_m,
        bgr=key.colour,
        boxes=key.boxes or [],
    )
points, colours, _ = world.cloud()
print(f"{len(points)} points")
low, high = points.min(axis=0), points.max(axis=0)
above = np.full((400, 400, 3), 255, np.uint8)
column, row = ((points - low) / (high - low) * 399).astype(int)[:, :2].T
above[row, column] = colours[:, ::-1]
cv2.imwrite(str(out / "map.png"), above)
print("pictures in", out)
