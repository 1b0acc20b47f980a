// SPDX-License-Identifier: MIT
// Each line runs ours and the reference alternately in the same run.
// `ratio` is the quotient of the medians.
// References: cv::calcOpticalFlowPyrLK, cv::BFMatcher with cross-check.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <dynfilter/correspondence/flow.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/video/tracking.hpp>
#include <random>

#include "correspondence/random_texture.hpp"

using namespace dynfilter;

namespace {

constexpr int kSets = 4;  // rotated, because a small repeated set stays in the cache

struct FlowSet {
  cv::Mat current, reference;
  std::vector<cv::Point2f> points;
};

std::vector<FlowSet> flow_sets() {
  std::vector<FlowSet> sets;
  const cv::Size size(640, 480);
  for (unsigned s = 0; s < kSets; ++s) {
    const test::WaveTexture texture(s + 1);
    const cv::Point2d shift(3.3 + s, -2.1 * s);
    cv::Mat noise = test::noise_image(size, s + 50, 1.0) / 16;
    sets.push_back({texture.image(size), texture.image(size, shift) + noise,
                    test::random_points(size, 1000, 20, s + 9)});
  }
  return sets;
}

struct DescriptorSet {
  std::vector<cv::KeyPoint> keypoints[2];
  cv::Mat descriptors[2];
};

std::vector<DescriptorSet> descriptor_sets() {
  std::vector<DescriptorSet> sets(kSets);
  std::mt19937 random(5);
  for (DescriptorSet& set : sets) {
    const auto points = test::random_points({640, 480}, 1000, 16, static_cast<unsigned>(random()));
    for (cv::Mat& d : set.descriptors) d.create(1000, 32, CV_8UC1);
    for (int i = 0; i < 1000; ++i) {
      const int octave = static_cast<int>(random() % 8);
      for (std::vector<cv::KeyPoint>& side : set.keypoints) {
        const auto jitter = [&] { return static_cast<float>(random() % 2000) / 100.0F - 10.0F; };
        const cv::Point2f moved = points[static_cast<std::size_t>(i)] + cv::Point2f(jitter(), jitter());
        side.emplace_back(moved, 31.0F, -1.0F, 1.0F, octave);
      }
      for (int b = 0; b < 32; ++b) {
        const auto byte = static_cast<unsigned char>(random() >> 24U);
        set.descriptors[0].at<unsigned char>(i, b) = byte;
        set.descriptors[1].at<unsigned char>(i, b) =
            static_cast<unsigned char>(byte ^ (random() % 8 == 0 ? 1U << (random() % 8) : 0U));
      }
    }
  }
  return sets;
}

/// CPU time of this thread, independent of other programs.
double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

template <class F>
double milliseconds(const F& f) {
  const double start = cpu_ms();
  f();
  return cpu_ms() - start;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// Runs ours and the reference alternately.
/// The reported time is ours, the counters contain the ratio of the medians.
template <class Ours, class Anchor>
void compare(benchmark::State& state, const Ours& ours, const Anchor& anchor) {
  cv::setNumThreads(1);
  std::vector<double> ours_ms, anchor_ms;
  std::size_t round = 0;
  for (auto _ : state) {
    const std::size_t set = round++ % kSets;
    const double ms = milliseconds([&] { ours(set); });
    ours_ms.push_back(ms);
    anchor_ms.push_back(milliseconds([&] { anchor(set); }));
    state.SetIterationTime(ms / 1e3);
  }
  state.counters["anchor_ms"] = median(anchor_ms);
  state.counters["ratio"] = median(ours_ms) / median(anchor_ms);
}

void flow(benchmark::State& state, FlowEngine engine, FlowCheck check) {
  static const std::vector<FlowSet> sets = flow_sets();
  FlowParams params = engine == FlowEngine::Guided ? FlowParams::guided() : FlowParams();
  params.engine = engine;
  params.check = check;
  FlowTracker tracker(params);
  ImagePyramid current;
  std::vector<ImagePyramid> references(kSets);  // built when they were current, as in a stream
  std::transform(sets.begin(), sets.end(), references.begin(), [&](const FlowSet& set) {
    ImagePyramid pyramid;
    tracker.build(set.reference, pyramid);
    return pyramid;
  });
  Correspondences found;
  std::vector<cv::Point2f> to;
  std::vector<unsigned char> status;
  std::vector<float> error;
  compare(
      state,
      [&](std::size_t s) {
        tracker.build(sets[s].current, current);
        tracker.track(current, references[s], sets[s].points, {}, found);
      },
      [&](std::size_t s) {
        cv::calcOpticalFlowPyrLK(sets[s].current, sets[s].reference, sets[s].points, to, status, error);
      });
  state.counters["found"] = static_cast<double>(found.count());
}

void descriptors(benchmark::State& state, double search_radius_px, int max_octave_difference) {
  static const std::vector<DescriptorSet> sets = descriptor_sets();
  DescriptorMatchParams params;
  params.search_radius_px = search_radius_px;
  params.max_octave_difference = max_octave_difference;
  DescriptorMatcher matcher(params);
  const cv::BFMatcher brute_force(cv::NORM_HAMMING, true);
  Correspondences found;
  std::vector<cv::DMatch> matches;
  compare(
      state,
      [&](std::size_t s) {
        matcher.match({sets[s].keypoints[0], sets[s].descriptors[0]},
                      {sets[s].keypoints[1], sets[s].descriptors[1]}, {}, found);
      },
      [&](std::size_t s) { brute_force.match(sets[s].descriptors[0], sets[s].descriptors[1], matches); });
  state.counters["found"] = static_cast<double>(found.count());
}

}  // namespace

BENCHMARK_CAPTURE(flow, guided_residual, FlowEngine::Guided, FlowCheck::Residual)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, guided_forward_backward, FlowEngine::Guided, FlowCheck::ForwardBackward)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, own_unchecked, FlowEngine::Own, FlowCheck::None)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, own_residual, FlowEngine::Own, FlowCheck::Residual)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, own_forward_backward, FlowEngine::Own, FlowCheck::ForwardBackward)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, opencv_unchecked, FlowEngine::OpenCv, FlowCheck::None)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, opencv_residual, FlowEngine::OpenCv, FlowCheck::Residual)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, opencv_forward_backward, FlowEngine::OpenCv, FlowCheck::ForwardBackward)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(descriptors, radius_50_px, 50, 1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(descriptors, radius_50_px_any_octave, 50, 100)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(descriptors, whole_image_any_octave, 10000, 100)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
