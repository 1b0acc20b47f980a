// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/motion/expiring.hpp>

#include "doctest/doctest.h"

namespace expiring_test {

using namespace dynfilter;

namespace {

constexpr double kFrame_s = 1.0 / 30;

template <class T>
void pass_frames(T& belief, double duration_s) {
  for (double s = kFrame_s; s < duration_s; s += kFrame_s) belief.pass(kFrame_s);
}

}  // namespace

TEST_CASE("expiring: known from a confirmation on, for a lifetime, and unknown after a second") {
  Expiring<int> plane;
  CHECK_FALSE(plane.value().has_value());
  plane.confirm(7);
  pass_frames(plane, 0.4);
  CHECK(plane.value() == 7);
  plane.confirm(8);
  pass_frames(plane, 0.4);
  CHECK(plane.value() == 8);  // 0.8 s after the first, but 0.4 s after the last confirmation
  pass_frames(plane, 0.6);
  CHECK_FALSE(plane.value().has_value());
  plane.confirm(9);
  plane.pass(10);  // the host paused: time counts, not frames
  CHECK_FALSE(plane.value().has_value());
}

// A and B confirm each other in turn. Each conclusion is as old as its premise, so no chain prolongs it.
TEST_CASE("expiring: what is inferred does not outlive what it was inferred from") {
  Expiring<int> a, b;
  a.confirm(1);
  for (int k = 0; k < 30; ++k) {
    a.pass(kFrame_s), b.pass(kFrame_s);
    if (a.value()) b.infer(*a.value(), a.since_s());
    if (b.value()) a.infer(*b.value(), b.since_s());
  }
  CHECK_FALSE(a.value().has_value());
  CHECK_FALSE(b.value().has_value());
}

TEST_CASE("expiring mean: the weighted mean of all observations, beside half a one that was 0") {
  constexpr double kMemory_s = 0.3;
  ExpiringMean mean;
  const double keep = std::exp(-kFrame_s / kMemory_s);
  double values = 0, weights = 0.5;
  for (const double value : {3.0, 1.0, 4.0, 1.0, 5.0}) {
    mean.pass(kFrame_s);
    mean.observe(value, kMemory_s);
    values = keep * values + value, weights = keep * weights + 1;
    CHECK(mean.value() == doctest::Approx(values / weights));
  }
  // A frame without an observation: the earlier ones are as old as they are.
  mean.pass(kFrame_s), mean.pass(kFrame_s);
  mean.observe(9, kMemory_s);
  CHECK(mean.value() == doctest::Approx((keep * keep * values + 9) / (keep * keep * weights + 1)));
}

TEST_CASE("expiring mean: neutral a second after the last observation, whatever was observed or inferred") {
  ExpiringMean observed, inferred;
  for (int k = 0; k < 60; ++k) observed.pass(kFrame_s), observed.observe(6, 0.5);
  CHECK(observed.value() > 5.9);
  CHECK_FALSE(observed.inferred());
  inferred.infer(observed.value(), observed.since_s());
  CHECK(inferred.value() == observed.value());
  CHECK(inferred.inferred());
  pass_frames(observed, 1), pass_frames(inferred, 1);
  for (const ExpiringMean* mean : {&observed, &inferred}) {
    CHECK(mean->value() == 0);
    CHECK_FALSE(mean->known());
  }
}

}  // namespace expiring_test
