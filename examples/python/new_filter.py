#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""From an idea to a figure: a filter of your own beside those of dynfilter.

    python3 examples/python/new_filter.py
"""

from dataclasses import dataclass

import numpy as np

import dynfilter


@dataclass
class MedianFlow(dynfilter.Filter, name="median_flow", needs="matches"):
    """Rejects features whose flow differs from that of most others."""

    max_difference_px: float = dynfilter.param(3.0, unit="px", min=0, max=100, doc="larger differences are dynamic")

    def apply(self, evidence: dynfilter.Evidence, votes: dynfilter.Votes) -> None:
        flow = evidence.undistorted_pixels - evidence.match().pixels  # NaN without a match
        if not np.isfinite(flow).any():
            return votes.note("no matches yet")
        difference = np.linalg.norm(flow - np.nanmedian(flow, axis=0), axis=1)
        votes.by_distance(difference, self.max_difference_px)


# One filter alone, as a unit test would ask.
alone = dynfilter.judge(MedianFlow(), dynfilter.ExactScene("general", pixel_noise_px=0.3))
print(f"alone: recall {alone.recall:.2f}, static kept {alone.static_kept:.2f}\n")

# The same in YAML, beside a filter of dynfilter.
both = """
pipeline:
  name: both
  before_pose:
    - any:
        - median_flow: { max_difference_px: 5 }
        - epipolar
"""
print(dynfilter.compare([MedianFlow(), "epipolar", both], ["general", "pure_rotation", "along_epipolar"]), "\n")

# And what it does to a trajectory.
sequence = dynfilter.render("walking_xyz", frames=40)
print(dynfilter.compare(["none", MedianFlow(), both, "dynfilter"], [sequence]))
