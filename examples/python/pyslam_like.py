#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The loop of a small visual odometry: ORB, the filter, PnP. Needs OpenCV for Python (python3-opencv).

    python3 examples/python/pyslam_like.py [FOLDER of a TUM RGB-D or Bonn sequence] [PIPELINE]
"""

import sys
from typing import Any, List, Optional

import cv2
import numpy as np

import dynfilter

Array = Any


def points_of(pixels: Array, frame: dynfilter.Frame) -> Array:
    """(n, 3) points in the frame of the camera [m]; NaN without depth."""
    assert frame.depth is not None
    x, y = np.rint(pixels).astype(int).T
    z = frame.depth[y, x] * frame.depth_unit_m
    z = np.where(z > 0, z, np.nan)
    K = frame.camera.matrix
    return np.stack([(pixels[:, 0] - K[0, 2]) / K[0, 0] * z, (pixels[:, 1] - K[1, 2]) / K[1, 1] * z, z], axis=1)


def motion(before: Array, now: Array, K: Array) -> Optional[Array]:
    """(4, 4) T_now_before from 3-D points and their pixels now."""
    use = np.isfinite(before).all(axis=1)
    if use.sum() < 10:
        return None
    found, rotation, translation, _ = cv2.solvePnPRansac(
        before[use].astype(np.float64), now[use].astype(np.float64), K, None, reprojectionError=2.0
    )
    if not found:
        return None
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(rotation)[0], translation[:, 0]
    return T


def track(sequence: dynfilter.Sequence, pipeline: str, frames: int) -> dynfilter.Ate:
    orb = cv2.ORB_create(nfeatures=1500)
    matcher = cv2.BFMatcher(cv2.NORM_HAMMING, crossCheck=True)
    judge = dynfilter.Pipeline(pipeline)
    pose, stamps, poses = np.eye(4), [], []  # type: Any, List[float], List[Any]
    last: Any = None
    for frame in (sequence[i] for i in range(min(frames, len(sequence)))):
        keypoints, descriptors = orb.detectAndCompute(frame.grey, None)
        verdict = judge.before_pose(keypoints, **frame.arguments())  # cv2.KeyPoint as they are
        keep = verdict.keep
        pixels, descriptors = cv2.KeyPoint_convert(keypoints)[keep], descriptors[keep]
        if last is not None:
            pairs = matcher.match(last[1], descriptors)
            T = motion(
                last[0][[m.queryIdx for m in pairs]], pixels[[m.trainIdx for m in pairs]], frame.camera.matrix
            )
            pose = pose if T is None else pose @ np.linalg.inv(T)
        last = points_of(pixels, frame), descriptors
        stamps.append(frame.timestamp)
        poses.append(pose)
    truth = sequence.ground_truth()
    assert truth is not None, "the sequence has no ground truth"
    return dynfilter.ate(truth, (np.array(stamps), np.array(poses)))


def main() -> None:
    folder = sys.argv[1] if len(sys.argv) > 1 else None
    pipeline = sys.argv[2] if len(sys.argv) > 2 else "dynfilter"
    sequence = dynfilter.Recording(folder) if folder else dynfilter.render("walking_xyz", frames=40)
    for name in ("none", pipeline):
        print(f"{name}: ATE {track(sequence, name, frames=200).rmse_m:.4f} m")


if __name__ == "__main__":
    main()
