#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes a mask per frame for a host that takes one: stella_vslam, OpenVINS, pySLAM, cuVSLAM, Kimera-VIO.

    python3 examples/python/mask_for_any_host.py [FOLDER] [OUT] [0_drops|255_drops]

Which host wants which polarity: docs/how-to/mask_hosts.md. Needs OpenCV for Python (python3-opencv).
"""

import sys
from pathlib import Path

import cv2

import dynfilter

folder = sys.argv[1] if len(sys.argv) > 1 else ""
out = Path(sys.argv[2] if len(sys.argv) > 2 else "masks_for_host")
polarity = sys.argv[3] if len(sys.argv) > 3 else "0_drops"
out.mkdir(parents=True, exist_ok=True)

sequence = dynfilter.Recording(folder) if folder else dynfilter.render("walking_xyz", frames=12)
pipeline = dynfilter.Pipeline("dynfilter")
dropped = 0.0
for frame in sequence:
    # Any detector will do: the host finds its own features under the mask.
    corners = cv2.goodFeaturesToTrack(frame.grey, 1000, 0.003, 8).reshape(-1, 2)
    verdict = pipeline.before_pose(corners, **frame.arguments())
    mask = verdict.mask(frame.grey.shape, polarity=polarity, rgbd=frame.depth is not None)
    dropped += float((mask == (0 if polarity == "0_drops" else 255)).mean())
    cv2.imwrite(str(out / f"{frame.timestamp:.6f}.png"), mask)
print(f"{len(sequence)} masks in {out}, which drop {100 * dropped / len(sequence):.1f} % of the pixels")
