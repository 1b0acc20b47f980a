#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A provider of boxes in a program of its own: the bright spot of each image. The standard library suffices.

The protocol is in docs/reference/provider_process.md. A detector's file that starts it:

    detector: { type: process, command: [ python3, examples/python/lamp_provider.py ] }
"""

import sys
from typing import BinaryIO, List, Tuple

Box = Tuple[int, float, int, int, int, int, str]


def detect(pixels: bytes, width: int, channels: int) -> List[Box]:
    """All pixels of 200 or more are one lamp: (class_id, score, x1, y1, x2, y2, name)."""
    bright = [i // channels for i in range(0, len(pixels), channels) if pixels[i] >= 200]
    if not bright:
        return []
    xs, ys = [i % width for i in bright], [i // width for i in bright]
    return [(0, 0.9, min(xs), min(ys), max(xs) + 1, max(ys) + 1, "lamp")]


def main(source: BinaryIO, sink: BinaryIO) -> None:
    def say(line: str) -> None:
        sink.write((line + "\n").encode("ascii"))

    say("dynfilter-provider 1")
    sink.flush()
    while True:
        words = source.readline().split()
        if not words:
            return
        frame_id = words[1].decode("ascii")
        width, height, channels = map(int, words[3:6])
        pixels = source.read(width * height * channels)
        say("result " + frame_id)
        try:
            found = detect(pixels, width, channels)
            say("detections %d" % len(found))
            for detection in found:
                say("%d %g %g %g %g %g %s" % detection)
            say("end")
        except Exception as error:
            say("error %s" % error)
        sink.flush()


main(sys.stdin.buffer, sys.stdout.buffer)
