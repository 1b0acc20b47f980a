#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From a fresh clone to a table and pictures. Installs missing packages, builds the dynfilter command, and renders a
# sequence with walking people. Then it runs an odometry with five pipelines: no rejection, RTS-SLAM as published,
# dynfilter without a detector, dynfilter with a detector's boxes, and the true labels.
# Safe to repeat, quick the second time.
#   bash examples/demo.sh [FOLDER]      default: ./out
set -eu
out=$(realpath -m "${1:-out}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. cmake/setup.sh

need_packages $build_packages
choose_tools

echo "Building (a few minutes the first time) ..."
mkdir -p build "$out"
cmake --preset command >build/command.log 2>&1 || { cat build/command.log; exit 1; }
cmake --build --preset command -j "$jobs" --target dynfilter
dynfilter=build/command/examples/dynfilter/dynfilter

sequence=$out/walking_xyz
[ -f "$sequence/groundtruth.txt" ] || "$dynfilter" synth walking_xyz "$sequence"

# The default pipeline without its stages for boxes and masks: what `run --no-detections --no-masks` does, too.
alone=$out/dynfilter_no_detector.yaml
sed -e '/- semantic_/d' -e 's/^  name: .*/  name: dynfilter_no_detector/' examples/pipelines/dynfilter.yaml >"$alone"

echo
"$dynfilter" compare "$sequence" --no-masks --pipelines "none,rts_slam_published,$alone,dynfilter,oracle"
echo
for pipeline in none "$alone" dynfilter; do
  folder=$out/$(basename "$pipeline" .yaml)
  rm -rf "$folder"
  "$dynfilter" run "$sequence" --no-masks --pipeline "$pipeline" --out "$folder" >/dev/null
done
echo "Next: your own tracker (door 1 of README.md), your own filter (2), your own recordings (3), a dense map (4)."
echo "The sequence: $sequence"
echo "Reports, a page each to open in a browser:"
for name in none dynfilter_no_detector dynfilter; do echo "  $out/$name/report.html"; done
echo "Pictures (static green, dynamic red with the stage that said so, unknown grey):"
echo "  $out/none/overlay"
echo "  $out/dynfilter_no_detector/overlay"
echo "  $out/dynfilter/overlay"
