#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# CPU time to compile one file that includes dynfilter.hpp, builds a pipeline from YAML and judges a frame: with the headers
# alone, and as a target that links dynfilter::compiled. Needs pkg-config, Eigen and OpenCV; builds nothing else.
#   bash test/benchmark/compile_time.sh                  with c++ -O2
#   bash test/benchmark/compile_time.sh g++ clang++-14   with these compilers
#   FLAGS=-O0 bash test/benchmark/compile_time.sh        with other flags
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
export CCACHE_DISABLE=1
[ $# -gt 0 ] || set -- c++
flags=${FLAGS--O2}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat >"$folder/host.cpp" <<'CODE'
#include <dynfilter/dynfilter.hpp>

std::size_t kept(const std::string& yaml, const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& grey) {
  dynfilter::Pipeline pipeline(dynfilter::pipeline_from_text(yaml, dynfilter::builtin_filters()));
  dynfilter::FrameView frame;
  frame.keypoints = keypoints;
  frame.grey = grey;
  return pipeline.before_pose(frame).kept();
}
CODE

libraries=$(pkg-config --cflags eigen3 "$(pkg-config --exists opencv4 && echo opencv4 || echo opencv5)")
# cpu_seconds COMPILER OPTIONS...
cpu_seconds() {
  local TIMEFORMAT='%U %S' compiler=$1
  shift
  { time "$compiler" -std=c++17 $flags "$@" -Iinclude $libraries -c "$folder/host.cpp" -o "$folder/host.o" 2>"$folder/errors"; } \
    2>"$folder/time" || { cat "$folder/errors" >&2; return 1; }
  awk '{ printf "%.1f s", $1 + $2 }' "$folder/time"
}

printf '%-14s %-8s %14s %20s\n' compiler flags "headers alone" dynfilter::compiled
for compiler in "$@"; do
  alone=$(cpu_seconds "$compiler")
  compiled=$(cpu_seconds "$compiler" -DDYNFILTER_COMPILED)
  printf '%-14s %-8s %14s %20s\n' "$compiler" "$flags" "$alone" "$compiled"
done
