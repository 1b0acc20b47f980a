#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints what a call costs beside its time in C++, for each form of keypoints. Not a test: see test_pipeline.py."""

import time

import cv2
import numpy as np

import dynfilter

FEATURES, CALLS = 1000, 300


def forms(arguments):
    records = arguments.pop("keypoints")[:FEATURES]
    points = np.stack([records["x"], records["y"]], axis=1)
    objects = [cv2.KeyPoint(float(k["x"]), float(k["y"]), 31.0, octave=int(k["octave"])) for k in records]
    return {"dynfilter.keypoint_type": records, "(n, 2) float32": points, "list of cv2.KeyPoint": objects}


def frames():
    scene = dynfilter.ExactScene(points=1400, movers=[dynfilter.MovingBox(100, step_m=(0.04, 0, 0))])
    for k in range(15):
        arguments = scene.frame(k).arguments()
        for key in ("depth_m", "matches"):
            if key in arguments:
                arguments[key] = np.ascontiguousarray(arguments[key][:FEATURES])
        if "matches" in arguments:
            arguments["matches"][arguments["matches"] >= FEATURES] = -1
        arguments.pop("keypoints_undistorted", None)
        yield forms(arguments), arguments


def extra_ms(form, recorded):
    pipeline, extra, in_cpp = dynfilter.Pipeline("dynfilter"), [], []
    for k in range(CALLS):
        keypoints, arguments = recorded[k % len(recorded)]
        arguments.update(timestamp=k / 30, frame_id=k)
        if "matches" in arguments:
            arguments["matches_frame_id"] = k - 1
        begin = time.perf_counter()
        verdict = pipeline.before_pose(keypoints[form], **arguments)
        keep = verdict.keep
        extra.append(1e3 * (time.perf_counter() - begin) - verdict.report.total_ms)
        in_cpp.append(verdict.report.total_ms)
        assert len(keep) == FEATURES
    return np.median(extra), np.quantile(extra, 0.9), np.median(in_cpp)


def main():
    recorded = list(frames())
    for form in recorded[0][0]:
        print("| {} | {:.3f} | {:.3f} | {:.2f} |".format(form, *extra_ms(form, recorded)))


if __name__ == "__main__":
    main()
