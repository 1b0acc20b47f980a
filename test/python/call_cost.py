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


def costs_ms(form, recorded):
    """CPU time of whole calls of the pipeline `none`, and wall time of calls of `dynfilter` beside their time in C++."""
    cpu, wall, in_cpp = [], [], []
    pipelines = {name: dynfilter.Pipeline(name) for name in ("none", "dynfilter")}
    for k in range(CALLS):
        keypoints, arguments = recorded[k % len(recorded)]
        arguments.update(timestamp=k / 30, frame_id=k)
        if "matches" in arguments:
            arguments["matches_frame_id"] = k - 1
        for name, pipeline in pipelines.items():
            began, began_cpu = time.perf_counter(), time.thread_time()
            verdict = pipeline.before_pose(keypoints[form], **arguments)
            keep = verdict.keep
            took_cpu, took = time.thread_time() - began_cpu, time.perf_counter() - began
            assert len(keep) == FEATURES
            if name == "none":
                cpu.append(1e3 * took_cpu)
        wall.append(1e3 * took - verdict.report.total_ms)
        in_cpp.append(verdict.report.total_ms)
    return [np.median(cpu), np.quantile(cpu, 0.9), np.median(wall), np.quantile(wall, 0.9), np.median(in_cpp)]


def main():
    recorded = list(frames())
    for form in recorded[0][0]:
        print("| {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.2f} |".format(form, *costs_ms(form, recorded)))


if __name__ == "__main__":
    main()
