// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/motion/moving_odds.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "doctest/doctest.h"

namespace track_evidence_test {

using namespace dynfilter;

namespace {

/// After `seconds` of frames that say the same.
float after(double seconds, double rate_hz, float ratio, float first = 0) {
  const TrackEvidence over_time(1 / rate_hz);
  float evidence = first;
  for (int k = 0; k < std::lround(seconds * rate_hz); ++k)
    evidence = over_time.with(over_time.faded(evidence), ratio);
  return evidence;
}

}  // namespace

TEST_CASE("track_evidence: what says nothing leads back to the prior") {
  for (const double rate_hz : {10.0, 30.0, 60.0}) {
    CHECK(after(1, rate_hz, 0) == 0.0F);
    CHECK(std::abs(after(1, rate_hz, 0, 13)) < 1e-3);
    CHECK(after(1, rate_hz, 0, -4) > -0.2F);  // rest is remembered longer
    CHECK(std::abs(after(4, rate_hz, 0, -4)) < 1e-3);
  }
}

TEST_CASE("track_evidence: the same motion is believed the same at 30, 60 and 120 Hz") {
  for (const float ratio : {0.1F, 0.5F, 2.0F, 5.0F}) {
    const float at_30 = after(1, 30, ratio);
    CHECK(after(1, 60, ratio) == doctest::Approx(at_30).epsilon(1e-3));
    CHECK(after(1, 120, ratio) == doctest::Approx(at_30).epsilon(1e-3));
    // Slower frames share less, and each counts at most once: less is believed, never more.
    CHECK(std::abs(after(1, 10, ratio)) < std::abs(at_30));
    CHECK(std::abs(after(1, 10, ratio)) >= std::abs(ratio));
  }
}

TEST_CASE("track_evidence: bounded, so that what was sure is overcome in some frames") {
  CHECK(after(5, 30, 9) == TrackEvidence::kMost);
  CHECK(after(5, 30, -9) == TrackEvidence::kLeast);
  CHECK(after(0.1, 30, -1, TrackEvidence::kMost) < TrackEvidence::kMost / 4);
  CHECK(after(0.1, 30, 3, TrackEvidence::kLeast) > 0.0F);
}

TEST_CASE("track_evidence: an error that stays the same adds up to its bound only, and takes nothing away") {
  const TrackEvidence over_time(1.0 / 30);
  float evidence = 0;
  for (int k = 0; k < 10; ++k) evidence = over_time.with(over_time.faded(evidence), 2, 3);
  CHECK(evidence == 3.0F);
  // What was sure already stays so, as far as it has not faded.
  CHECK(over_time.with(8, 5, 3) == 8.0F);
  CHECK(over_time.with(8, -2, 3) == 6.0F);
  CHECK(over_time.with(1, 1, 3) == 2.0F);
}

// The sum over the whole track by definition: each ratio with its own weight and age.
TEST_CASE("track_evidence: a twin that sums over the track, at any times") {
  cv::RNG rng(3);
  const double gain_at_30 = 1 - std::exp(-1 / (30 * TrackEvidence::kMotion_s));
  for (int track = 0; track < 50; ++track) {
    const bool moves = track % 2 == 0;
    const double memory_s = moves ? TrackEvidence::kMotion_s : TrackEvidence::kRest_s;
    std::vector<std::pair<double, double>> seen;  // time, weighted ratio
    float evidence = 0;
    double now_s = 0;
    for (int k = 0; k < 20; ++k) {
      const double elapsed_s = rng.uniform(0.005, 0.15), ratio = (moves ? 1 : -0.3) * rng.uniform(0.1, 1.0);
      now_s += elapsed_s;
      const TrackEvidence over_time(elapsed_s);
      evidence = over_time.with(over_time.faded(evidence), static_cast<float>(ratio));
      const double fresh = (1 - std::exp(-elapsed_s / TrackEvidence::kMotion_s)) / gain_at_30;
      seen.emplace_back(now_s, std::min(1.0, fresh) * ratio);
    }
    double sum = 0;
    for (const auto& [at_s, ratio] : seen) sum += ratio * std::exp(-(now_s - at_s) / memory_s);
    CHECK(evidence == doctest::Approx(sum).epsilon(1e-3));
  }
}

}  // namespace track_evidence_test
