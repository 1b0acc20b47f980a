// SPDX-License-Identifier: MIT
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <algorithm>
#include <opencv2/core/utility.hpp>
#include "confined.hpp"
#include "crowds.hpp"
#include "pipelines.hpp"
using namespace dynfilter;
int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const std::size_t n = std::strtoul(argv[1], nullptr, 10);
  const int frames = std::atoi(argv[2]);
  const double most = std::atof(argv[3]);
  const char* want_p = argc > 4 ? argv[4] : "";
  const char* want_a = argc > 5 ? argv[5] : "";
  const bool here = argc > 6;
  for (const auto& a : crowds::arrangements()) {
    if (std::strlen(want_a) && a.name != want_a) continue;
    std::vector<crowds::Crowd> cs;
    for (int k = 0; k < frames; ++k) cs.push_back(crowds::crowd(a, n, k));
    for (const auto& p : crowds::pipelines()) {
      if (std::strlen(want_p) && p.name != want_p) continue;
      auto f = [&] {
        Pipeline pipeline(crowds::made(p));
        double longest = 0;
        std::string said;
        for (auto& c : cs) {
          const FrameView v = c.view();
          const double b = confined::cpu_s();
          for (auto cp : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
            const Verdict& verdict = pipeline.process(v, cp);
            for (auto& s : verdict.report.stages) if (s.failed) said = s.note;
          }
          longest = std::max(longest, confined::cpu_s() - b);
        }
        if (!said.empty()) std::printf("failed: %s\n", said.c_str()), std::fflush(stdout);
        return longest;
      };
      if (here) { std::printf("%f\n", f()); continue; }
      const auto o = confined::run(most, f);
      std::printf("%-30s | %-28s | %7.3f s %7.1f MB %s\n", a.name.c_str(), p.name.c_str(), o.cpu_s, o.growth_MB, confined::to_string(o.end).c_str());
      std::fflush(stdout);
    }
  }
}
