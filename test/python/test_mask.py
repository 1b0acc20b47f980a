# SPDX-License-Identifier: MIT
import numpy as np
import pytest

import dynfilter

SHAPE = (200, 300)
PLACES = np.float32([[60, 60], [200, 100], [212, 100]])


class SecondAndFirst(dynfilter.Filter):
    """Rejects features 0 and 1, keeps 2, which is near 1."""

    def apply(self, evidence, votes):
        votes.dynamic([0, 1])


@pytest.fixture
def verdict():
    # The floor of a filter on its own keeps 50 features: these are the rest.
    others = np.full((60, 2), np.nan, np.float32)
    return dynfilter.Pipeline(SecondAndFirst()).before_pose(
        np.concatenate([PLACES, others]), timestamp=0, octaves=[0, 2] + [0] * 61
    )


def area(radius):
    return np.pi * radius**2


def test_discs_of_rejected_features(verdict):
    mask = verdict.mask(SHAPE, radius_px=10, keep_radius_px=3)
    assert mask.shape == SHAPE and set(np.unique(mask)) == {0, 255}
    assert mask[60, 60] == mask[60, 69] == 255 and mask[60, 72] == mask[73, 60] == 0
    octave_2 = round(10 * 1.2**2)
    assert mask[100, 200 - 13] == 255 and mask[100, 200 - 16] == 0
    assert mask[100, 212] == mask[100, 209] == 0  # the kept feature's surroundings
    assert (mask[:, :130] == 255).sum() == pytest.approx(area(10), rel=0.1)
    assert (mask[:, 130:201] == 255).sum() == pytest.approx(area(octave_2) / 2, rel=0.1)


def test_polarity(verdict):
    drops_255, drops_0 = verdict.mask(SHAPE), verdict.mask(SHAPE, polarity="0_drops")
    np.testing.assert_array_equal(drops_0, 255 - drops_255)
    with pytest.raises(ValueError, match="polarity: expected \"255_drops\" or \"0_drops\""):
        verdict.mask(SHAPE, polarity="white")
    with pytest.raises(ValueError, match="shape: expected \\(height, width\\)"):
        verdict.mask(300)


def test_depth_with_holes(verdict):
    depth = np.full(SHAPE, 1000, np.uint16)
    holes = verdict.depth(depth)
    np.testing.assert_array_equal(holes == 0, verdict.mask(SHAPE) == 255)
    assert (depth == 1000).all() and holes.dtype == np.uint16
    assert verdict.depth(depth.astype(np.float32)).dtype == np.float32


def test_ids(verdict):
    assert list(verdict.rejected_ids(np.arange(100, 163))) == [100, 101]
    with pytest.raises(ValueError, match=r"ids: expected integers of shape \(63,\)"):
        verdict.rejected_ids([1, 2])


def test_no_kept_feature_is_under_the_mask(rendered):
    """A mask must not starve the host."""
    pipeline = dynfilter.Pipeline("dynfilter")
    y, x = np.mgrid[8:472:8, 8:632:8]
    lattice = np.float32([x.ravel(), y.ravel()]).T
    for frame in rendered:
        verdict = pipeline.before_pose(lattice, **frame.arguments())
    mask = verdict.mask(frame.grey.shape, polarity="0_drops")
    u, v = lattice[verdict.keep].astype(int).T
    assert 0 < verdict.report.rejected and (mask[v, u] == 255).all()
    boxes = np.zeros(frame.grey.shape, bool)
    for box in frame.boxes:
        left, top, width, height = (int(side) for side in box.box)
        if box.class_name == "person":
            boxes[max(0, top) : top + height, max(0, left) : left + width] = True
    assert (mask == 0).mean() < boxes.mean()  # less than the boxes would drop


def test_draw(verdict):
    image = np.zeros(SHAPE, np.uint8)
    drawn = verdict.draw(image)
    assert drawn.shape == (*SHAPE, 3) and drawn.any() and not image.any()
