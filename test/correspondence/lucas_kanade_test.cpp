// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/lucas_kanade.hpp>
#include <dynfilter/correspondence/patch_kernels.hpp>
#include <limits>
#include <opencv2/video/tracking.hpp>

#include "correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace lucas_kanade_test {

using namespace dynfilter;

namespace {

struct Tracked {
  std::vector<cv::Point2f> px;
  std::vector<std::uint8_t> status;
};

Tracked own(const LucasKanade& tracker, const ImagePyramid& a, const ImagePyramid& b,
            const std::vector<cv::Point2f>& points, std::size_t stride = 2) {
  Tracked out{points, {}};
  std::vector<MatchSpread> spread;
  tracker.track(a.levels(), b.levels(), stride, points, out.px, out.status, spread);
  return out;
}

Tracked opencv(const LucasKanade& tracker, const ImagePyramid& a, const ImagePyramid& b,
               const std::vector<cv::Point2f>& points) {
  Tracked out{points, {}};
  cv::calcOpticalFlowPyrLK(
      a.levels(), b.levels(), points, out.px, out.status, cv::noArray(),
      {tracker.window_px, tracker.window_px}, tracker.levels,
      {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, tracker.max_iterations, tracker.epsilon_px},
      cv::OPTFLOW_USE_INITIAL_FLOW, tracker.min_eigenvalue);
  return out;
}

}  // namespace

TEST_CASE("It finds what OpenCV finds, near the borders too") {
  for (const int window_px : {13, 21, 30}) {
    LucasKanade tracker;
    tracker.window_px = window_px;
    REQUIRE(LucasKanade::supports(window_px));
    const cv::Size size(400, 300);
    const test::WaveTexture texture(static_cast<unsigned>(window_px));
    ImagePyramid a, b;
    a.build(texture.image(size), window_px, 3);
    b.build(texture.image(size, {4.3, -2.8}) + test::noise_image(size, 1, 0) / 16, window_px, 3);
    const auto points = test::random_points(size, 500, 0, 2);
    const Tracked ours = own(tracker, a, b, points), theirs = opencv(tracker, a, b, points);
    int compared = 0, alike = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!cv::Rect2f(0, 0, 399, 299).contains(theirs.px[i]) || theirs.status[i] == 0) continue;
      CHECK(ours.status[i] == 1);
      ++compared;
      const bool close = cv::norm(theirs.px[i] - ours.px[i]) < 0.02;
      alike += close ? 1 : 0;
      if (cv::Rect2f(15, 15, 369, 269).contains(points[i])) CHECK(close);
    }
    CHECK(compared > 450);
    CHECK(alike > 0.92 * compared);  // half a patch at the border is ambiguous for both
  }
}

TEST_CASE("Its results do not depend on threads, on other points, or on derivatives in the pyramid") {
  const cv::Size size(400, 300);
  const test::WaveTexture texture(3);
  ImagePyramid a, b, plain_a, plain_b;
  const cv::Mat current = texture.image(size), reference = texture.image(size, {-3, 5});
  a.build(current, 21, 3);
  b.build(reference, 21, 3);
  plain_a.build(current, 21, 3, false);
  plain_b.build(reference, 21, 3, false);
  CHECK(plain_a.levels().size() == 4);
  const auto points = test::random_points(size, 300, 0, 4);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const Tracked one = own(LucasKanade(), a, b, points);
  cv::setNumThreads(2);
  const Tracked two = own(LucasKanade(), a, b, points);
  cv::setNumThreads(threads);
  CHECK(one.px == two.px);
  CHECK(one.status == two.status);
  CHECK(own(LucasKanade(), plain_a, plain_b, points, 1).px == one.px);
  for (std::size_t i = 0; i < 20; ++i) CHECK(own(LucasKanade(), a, b, {points[i]}).px[0] == one.px[i]);
}

TEST_CASE("Flat images and wild positions are lost, not followed") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const cv::Mat image = test::noise_image({100, 80}, 5, 1);
  ImagePyramid textured, flat;
  textured.build(image, 21, 2);
  flat.build(cv::Mat(80, 100, CV_8UC1, cv::Scalar(200)), 21, 2);
  CHECK(own(LucasKanade(), flat, textured, {{50, 40}}).status[0] == 0);
  const std::vector<cv::Point2f> wild{{nan, 40}, {50, inf}, {-1e30F, 40}, {3e9F, 40},
                                      {-50, 40}, {50, 200}, {50, 40}};
  const std::vector<std::uint8_t> status{0, 0, 0, 0, 0, 0, 1};
  CHECK(own(LucasKanade(), textured, textured, wild).status == status);
  Tracked guessed{wild, {}};
  const std::vector<cv::Point2f> from(wild.size(), {50, 40});
  std::vector<MatchSpread> spread;
  LucasKanade().track(textured.levels(), textured.levels(), 2, from, guessed.px, guessed.status, spread);
  CHECK(guessed.status == status);
}

TEST_CASE("Wider instructions give the same bits, in every window, at borders and on noise") {
  if (!uses_avx2()) MESSAGE("no AVX2 here: both runs take the same path");
  const cv::Size size(151, 118);
  const test::WaveTexture texture(9);
  for (int window_px = 3; window_px <= detail::Patch::kMaxWindow; ++window_px) {
    if (!LucasKanade::supports(window_px)) continue;
    const auto w = static_cast<unsigned>(window_px);
    LucasKanade wide, narrow;
    wide.window_px = narrow.window_px = window_px;
    narrow.wide = false;
    for (const bool noise : {false, true}) {
      ImagePyramid a, b;
      a.build(noise ? test::noise_image(size, w, 0) : texture.image(size), window_px, 3, false);
      b.build(noise ? test::noise_image(size, w + 1, 0) : texture.image(size, {2.6, -1.3}), window_px, 3,
              false);
      const auto points = test::random_points(size, 60, 0, w);
      const Tracked one = own(wide, a, b, points, 1), two = own(narrow, a, b, points, 1);
      CHECK(one.status == two.status);
      CHECK(std::memcmp(one.px.data(), two.px.data(), points.size() * sizeof(points[0])) == 0);
    }
  }
}

TEST_CASE("Every window that it supports reads within the border, on images of any size") {
  int supported = 0;
  for (int window_px = 3; window_px <= 80; ++window_px) {
    if (!LucasKanade::supports(window_px)) continue;
    ++supported;
    LucasKanade tracker;
    tracker.window_px = window_px;
    for (const cv::Size size : {cv::Size(1, 1), {7, 90}, {70, 66}, {71, 66}}) {
      tracker.wide = size.width != 71;
      ImagePyramid a;
      a.build(test::noise_image(size, 6, 0), window_px, 3, false);
      const float right = static_cast<float>(size.width - 1), bottom = static_cast<float>(size.height - 1);
      // The sanitizers check the corners.
      const Tracked found =
          own(tracker, a, a, {{0, 0}, {right, 0}, {0, bottom}, {right, bottom}, {right / 2, bottom / 2}}, 1);
      CHECK(found.status.size() == 5);
      if (size.width >= 70) CHECK(found.status[4] == 1);
      if (size.width >= 70) CHECK(cv::norm(found.px[4] - cv::Point2f(right / 2, bottom / 2)) < 0.01);
    }
  }
  CHECK(supported > 40);
  CHECK(LucasKanade::supports(21));
  CHECK_FALSE(LucasKanade::supports(5));
  CHECK_FALSE(LucasKanade::supports(64));
}

}  // namespace lucas_kanade_test
