// SPDX-License-Identifier: MIT
// A pair of frames at first sight: recall and precision of the default filter, without a detector, over many
// pairs. The goals are a recall of 0.9 at a precision of 0.9. Features near outlines, and those that moved
// less than 10 mm or 1 px, do not count.
//   two_frames_benchmark [PAIRS [SEED...]]     10 pairs of each of the seeds 11, 12 and 13
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "support/two_frames.hpp"

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 10;
  std::vector<std::uint64_t> seeds;
  for (int k = 2; k < argc; ++k) seeds.push_back(std::strtoull(argv[k], nullptr, 10));
  if (seeds.empty()) seeds = {11, 12, 13};
  constexpr int kFirst = 20, kApart = 17;  // movers of every scene move by then
  std::printf("| scene | gap | pairs | recall | precision | pairs below 0.9 in either |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const std::string scene :
       {"walking_xyz", "walking_static", "walking_rpy", "walking_halfsphere", "crowd"})
    for (const int gap : {1, 2, 3}) {
      dynfilter::eval::Classification all;
      int below = 0, judged = 0;
      for (const std::uint64_t seed : seeds) {
        dynfilter::render::SequenceRenderer renderer(two_frames::options(scene, seed, gap));
        for (int k = 0; k < pairs; ++k) {
          const dynfilter::eval::Classification pair = two_frames::judge(renderer, kFirst + k * kApart, gap);
          all.add(pair);
          ++judged;
          below += !(pair.recall() >= 0.9 && pair.precision() >= 0.9) ? 1 : 0;
        }
      }
      std::printf("| %s | %d | %d | %.3f | %.3f | %d |\n", scene.c_str(), gap, judged, all.recall(),
                  all.precision(), below);
      std::fflush(stdout);
    }
}
