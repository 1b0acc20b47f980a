#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From a fresh clone to a table and pictures: installs what is missing, builds the dynfilter command, renders a
# sequence with walking people, and runs an odometry on it without rejection, with the published RTS-SLAM, with ours,
# and with the true labels. Safe to repeat, quick the second time.
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
echo
"$dynfilter" compare "$sequence" --pipelines none,rts_slam_published,rts_slam,oracle
echo
for pipeline in none rts_slam; do
  rm -rf "$out/$pipeline"
  "$dynfilter" run "$sequence" --pipeline "$pipeline" --out "$out/$pipeline" >/dev/null
done
echo "Pictures (static green, dynamic red with the reason, unknown grey):"
echo "  $out/none/overlay"
echo "  $out/rts_slam/overlay"
echo "The sequence itself: $sequence"
