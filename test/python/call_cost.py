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


def calls_ms(pipeline, form, recorded):
    """Of each call: CPU time, elapsed time, and the time in C++."""
    judge, times = dynfilter.Pipeline(pipeline), []
    for k in range(CALLS):
        keypoints, arguments = recorded[k % len(recorded)]
        arguments.update(timestamp=k / 30, frame_id=k)
        if "matches" in arguments:
            arguments["matches_frame_id"] = k - 1
        began, began_cpu = time.perf_counter(), time.thread_time()
        verdict = judge.before_pose(keypoints[form], **arguments)
        keep = verdict.keep
        times.append((1e3 * (time.thread_time() - began_cpu), 1e3 * (time.perf_counter() - began), verdict.report.total_ms))
        assert len(keep) == FEATURES
    return np.array(times).T


def cpu_ms(form, recorded):
    """CPU times of whole calls of a pipeline without stages."""
    return calls_ms("none", form, recorded)[0]


def main():
    recorded = list(frames())
    for form in recorded[0][0]:
        _, elapsed, in_cpp = calls_ms("dynfilter", form, recorded)
        both = (cpu_ms(form, recorded), elapsed - in_cpp)
        figures = [value for times in both for value in (np.median(times), np.quantile(times, 0.9))]
        print("| {} | {:.3f}, {:.3f} | {:.3f}, {:.3f} | {:.2f} |".format(form, *figures, np.median(in_cpp)))


if __name__ == "__main__":
    main()
