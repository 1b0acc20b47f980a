# SPDX-License-Identifier: MIT
import cv2
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


def test_radius_of_the_sensor(verdict):
    for options, radius in [({}, 7), ({"rgbd": True}, 14), ({"radius_px": 9}, 9), ({"radius_px": 9, "rgbd": True}, 9)]:
        row = verdict.mask(SHAPE, **options)[60, :130]
        assert (row == 255).sum() == 2 * radius + 1 and row[60] == 255


def test_right_image(verdict):
    n = 63  # of the fixture: those behind the first three are nowhere
    left, right = verdict.mask(SHAPE), verdict.mask(SHAPE, right_u=np.r_[40, 180, 192, [-1] * (n - 3)])
    np.testing.assert_array_equal(right[:, :-20], left[:, 20:])
    assert not verdict.mask(SHAPE, right_u=np.full(n, -1.0)).any()
    with pytest.raises(ValueError, match="right_u"):
        verdict.mask(SHAPE, right_u=[40, 180])


def test_polarity(verdict):
    drops_255, drops_0 = verdict.mask(SHAPE), verdict.mask(SHAPE, polarity="0_drops")
    np.testing.assert_array_equal(drops_0, 255 - drops_255)
    with pytest.raises(ValueError, match="polarity: expected one of 255_drops, 0_drops, got `white`"):
        verdict.mask(SHAPE, polarity="white")
    with pytest.raises(ValueError, match="shape: expected \\(height, width\\)"):
        verdict.mask(300)


def test_depth_with_holes(verdict):
    depth = np.full(SHAPE, 1000, np.uint16)
    holes = verdict.depth(depth)
    np.testing.assert_array_equal(holes == 0, verdict.mask(SHAPE, rgbd=True) == 255)
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


class PySlam:
    """pySLAM as its source says (docs/how-to/mask_hosts.md): OpenCV's detectors find features where the mask is not 0."""

    def track(self, img, img_right, depth, img_id, timestamp=None, mask=None, mask_right=None):
        images = [(img, mask)] + ([(img_right, mask_right)] if img_right is not None else [])
        for image, of in images:
            assert of is None or (of.dtype == np.uint8 and of.shape == image.shape[:2])
        orb = cv2.ORB_create(2000)
        return [np.float32([k.pt for k in orb.detect(image, of)]) for image, of in images]


class CuVslamTracker:
    """cuVSLAM's tracker as its KITTI example uses it: a mask per image, uint8, 255 drops. It keeps left features only."""

    def track(self, timestamp, images, masks=None):
        assert isinstance(timestamp, int)  # nanoseconds
        if masks is not None:
            assert len(masks) == len(images)
            for image, mask in zip(images, masks):
                assert mask.dtype == np.uint8 and mask.shape == image.shape and mask.flags.c_contiguous
                assert set(np.unique(mask)) <= {0, 255}
        corners = cv2.goodFeaturesToTrack(images[0], 1000, 0.003, 8).reshape(-1, 2)
        if masks is None:
            return corners
        u, v = corners.astype(int).T
        return corners[masks[0][v, u] != 255]


@pytest.fixture(scope="module")
def judged(rendered):
    """The last frame, and a verdict on its corners."""
    pipeline = dynfilter.Pipeline("dynfilter")
    for frame in rendered:
        corners = cv2.goodFeaturesToTrack(frame.grey, 1000, 0.003, 8).reshape(-1, 2)
        verdict = pipeline.before_pose(corners, **frame.arguments())
    return frame, verdict


def on_movers(frame, places):
    u, v = places.astype(int).T
    return (frame.truth[v, u] == 255).mean(), len(places)


def test_pyslam_detects_less_on_movers(judged):
    frame, verdict = judged
    slam, image = PySlam(), frame.grey
    (before,) = slam.track(image, None, frame.depth, 11, frame.timestamp)
    mask = verdict.mask(image.shape, polarity="0_drops")
    (after,) = slam.track(image, None, frame.depth, 11, frame.timestamp, mask)
    (movers, features), (movers_left, features_left) = on_movers(frame, before), on_movers(frame, after)
    assert movers > 0.1 and movers_left < 0.3 * movers
    assert features_left > 0.5 * features  # the host is not starved
    left, right = slam.track(image, image, None, 11, frame.timestamp, mask)
    assert len(left) == features_left and len(right) == features  # without mask_right the right image is whole


def test_cuvslam_drops_what_is_255(judged):
    frame, verdict = judged
    tracker, image = CuVslamTracker(), frame.grey
    mask = verdict.mask(image.shape, polarity="255_drops")
    stamp_ns = int(frame.timestamp * 1e9)
    before = tracker.track(stamp_ns, [image, image])
    after = tracker.track(stamp_ns, [image, image], [mask, np.zeros_like(mask)])
    (movers, features), (movers_left, features_left) = on_movers(frame, before), on_movers(frame, after)
    assert movers > 0.1 and movers_left < 0.1 * movers
    assert features_left > 0.5 * features
