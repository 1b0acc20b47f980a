#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# CPU time to compile one file, of dynfilter's headers how many it includes, and their lines:
#   (a) includes dynfilter.hpp, builds a pipeline from YAML and judges a frame
#   (d) the same, header-only    (e) the same, header-only, with the filter that it registers instead of all
#   (b) a plugin with one filter (examples/03_custom_filter)
#   (c) calls the ORB-SLAM adapter as Tracking.cc does, with the types of test/hosts, and the same without the adapter
# One process at a time. Needs pkg-config, Eigen and OpenCV; builds nothing else.
#   bash test/benchmark/compile_time.sh                  with c++ -O2
#   bash test/benchmark/compile_time.sh g++ clang++-14   with these compilers
#   FLAGS=-O0 bash test/benchmark/compile_time.sh        with other flags
#   ONLY="a c" bash test/benchmark/compile_time.sh       only some of the files
set -eu
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
export CCACHE_DISABLE=1
[ $# -gt 0 ] || set -- c++
flags=${FLAGS--O2}
only=${ONLY-a b c d e}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat >"$folder/a.cpp" <<'CODE'
#include <dynfilter/dynfilter.hpp>

std::size_t kept(const std::string& yaml, const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& grey) {
  dynfilter::Pipeline pipeline(dynfilter::pipeline_from_text(yaml, dynfilter::builtin_filters()));
  dynfilter::FrameView frame;
  frame.keypoints = keypoints;
  frame.grey = grey;
  return pipeline.before_pose(frame).kept();
}
CODE
sed -e 's|dynfilter/dynfilter.hpp|dynfilter/filters/background_motion.hpp>\n#include <dynfilter/pipeline/pipeline_yaml.hpp|' \
  -e 's|^  dynfilter::Pipeline|  dynfilter::Registry registry;\n  registry.add<dynfilter::BackgroundMotionFilter>();\n&|' \
  -e 's|dynfilter::builtin_filters()|registry|' "$folder/a.cpp" >"$folder/e.cpp"
# What a fork adds to Tracking.cc and Tracking.h.
cat >"$folder/with.cpp" <<'CODE'
#include "hosts/host_stand_ins.hpp"

#include <dynfilter/hosts/orb_slam.hpp>
#include <iostream>

struct Tracking {
  std::unique_ptr<dynfilter::OrbSlam> filter;
  host::v2::Frame frame, last;
  std::vector<host::v2::KeyFrame*> local;

  explicit Tracking(const std::string& settings)
      : filter(dynfilter::OrbSlam::start(settings, 2, [](const std::string& line) { std::cout << line; })) {}
  void track(const cv::Mat& grey, const cv::Mat& depth) {
    if (filter) filter->before_tracking(frame, grey, depth, true, dynfilter::orb_slam::predicted_pose(cv::Mat(), last));
    if (filter) filter->after_pose(frame);
  }
  void make_keyframe() {
    if (filter) filter->at_keyframe(frame, local);
  }
};
void track(Tracking& tracking, const cv::Mat& grey, const cv::Mat& depth) {
  tracking.track(grey, depth);
  tracking.make_keyframe();
}
CODE
cat >"$folder/without.cpp" <<'CODE'
#include "hosts/host_stand_ins.hpp"

#include <iostream>
#include <memory>
#include <string>

struct Tracking {
  host::v2::Frame frame, last;
  std::vector<host::v2::KeyFrame*> local;
};
void track(Tracking& tracking, const cv::Mat& grey, const cv::Mat& depth) {
  std::cout << tracking.frame.N << grey.rows << depth.rows;
}
CODE

libraries=$(pkg-config --cflags eigen3 "$(pkg-config --exists opencv4 && echo opencv4 || echo opencv5)")
# row WHAT COMPILER SOURCE OPTIONS...
row() {
  local TIMEFORMAT='%U %S' what=$1 compiler=$2 source=$3
  shift 3
  set -- -std=c++17 $flags "$@" -Iinclude -Itest $libraries
  { time "$compiler" "$@" -c "$source" -o "$folder/object.o" 2>"$folder/errors"; } 2>"$folder/time" ||
    { cat "$folder/errors" >&2; return 1; }
  "$compiler" "$@" -M "$source" | tr ' \\' '\n\n' | grep '^include/dynfilter/' | sort -u >"$folder/headers" || true
  local lines=0
  [ ! -s "$folder/headers" ] || lines=$(xargs cat <"$folder/headers" | wc -l)
  printf '%-12s %-6s %-34s %8s %9s %8s\n' "$compiler" "$flags" "$what" \
    "$(awk '{ printf "%.1f", $1 + $2 }' "$folder/time")" "$(wc -l <"$folder/headers")" "$lines"
}

printf '%-12s %-6s %-34s %8s %9s %8s\n' compiler flags file "CPU s" headers lines
for compiler in "$@"; do
  case " $only " in *" a "*) row "(a) pipeline from YAML" "$compiler" "$folder/a.cpp" ;; esac
  case " $only " in *" b "*) row "(b) plugin with one filter" "$compiler" examples/03_custom_filter/median_flow.cpp ;; esac
  case " $only " in *" c "*)
    row "(c) ORB-SLAM with the adapter" "$compiler" "$folder/with.cpp"
    row "    the same without" "$compiler" "$folder/without.cpp" ;;
  esac
  case " $only " in *" d "*) row "(d) as (a), header-only" "$compiler" "$folder/a.cpp" -DDYNFILTER_HEADER_ONLY ;; esac
  case " $only " in *" e "*) row "(e) as (d), one filter registered" "$compiler" "$folder/e.cpp" -DDYNFILTER_HEADER_ONLY ;; esac
done
