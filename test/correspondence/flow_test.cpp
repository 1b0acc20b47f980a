// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/correspondence/flow.hpp>
#include <limits>

#include "correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace flow_test {

using namespace dynfilter;

namespace {

const cv::Size kSize(320, 240);
const float kNan = std::numeric_limits<float>::quiet_NaN();

FlowParams with(FlowCheck check, FlowEngine engine = FlowEngine::Own) {
  FlowParams params;
  params.check = check;
  params.engine = engine;
  return params;
}

Correspondences track(const cv::Mat& current, const cv::Mat& reference,
                      const std::vector<cv::Point2f>& points, const FlowParams& params = FlowParams(),
                      const std::vector<cv::Point2f>& guess = {}) {
  FlowTracker tracker(params);
  ImagePyramid a, b;
  tracker.build(current, a);
  tracker.build(reference, b);
  Correspondences out;
  tracker.track(a, b, points, guess, out);
  return out;
}

// In a texture shifted by +shift, every point is `shift` further left and up in the image.
void check_shift(const Correspondences& found, const std::vector<cv::Point2f>& points, cv::Point2f shift,
                 float tolerance_px) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (found.found[i] == 0) continue;
    CHECK(std::hypot(found.reference_px[i].x - points[i].x + shift.x,
                     found.reference_px[i].y - points[i].y + shift.y) < tolerance_px);
  }
}

bool same_bits(const std::vector<cv::Point2f>& a, const std::vector<cv::Point2f>& b) {
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const cv::Point2f& p, const cv::Point2f& q) {
    return same(p.x, q.x) && same(p.y, q.y);
  });
}

}  // namespace

TEST_CASE("A known sub-pixel shift is recovered to a tenth of a pixel") {
  const test::WaveTexture texture(1);
  const cv::Mat current = texture.image(kSize);
  const auto points = test::random_points(kSize, 300, 25, 2);
  for (const cv::Point2d shift : {cv::Point2d(0, 0), {0.37, -0.61}, {3.25, 2.5}, {-9.7, 6.1}})
    for (const FlowEngine engine : {FlowEngine::Own, FlowEngine::OpenCv}) {
      const Correspondences found =
          track(current, texture.image(kSize, shift), points, with(FlowCheck::ForwardBackward, engine));
      CHECK(found.size() == points.size());
      CHECK(found.count() >= 295);
      check_shift(found, points, shift, 0.1F);
      CHECK(found.reference_index == std::vector<std::int32_t>(points.size(), -1));
    }
}

TEST_CASE("Between unrelated images less than 2 % is found") {
  const auto points = test::random_points({640, 480}, 1000, 20, 3);
  for (const double sigma_px : {0.0, 1.5, 3.0})
    for (const FlowCheck check : {FlowCheck::Residual, FlowCheck::ForwardBackward}) {
      if (check == FlowCheck::Residual && sigma_px > 2)
        continue;  // a few blobs per patch contain too little information
      CAPTURE(sigma_px);
      CAPTURE(check);
      const Correspondences found = track(test::noise_image({640, 480}, 4, sigma_px),
                                          test::noise_image({640, 480}, 5, sigma_px), points, with(check));
      CHECK(found.count() < 20);
    }
  // LK's own status accepts nearly all of them.
  const Correspondences believed = track(test::noise_image({640, 480}, 4, 0),
                                         test::noise_image({640, 480}, 5, 0), points, with(FlowCheck::None));
  CHECK(believed.count() > 700);
}

TEST_CASE("Points that are NaN, outside or in the border are not found and do not disturb the others") {
  const test::WaveTexture texture(6);
  const cv::Mat image = texture.image(kSize);
  const std::vector<cv::Point2f> points{
      {100, 100}, {kNan, 50}, {50, kNan},    {-3, 20}, {320, 100}, {1e30F, 5},     {4.9F, 100},
      {5, 100},   {314, 100}, {314.1F, 100}, {100, 4}, {100, 235}, {-1e30F, 3e9F}, {150.5F, 120.5F}};
  const Correspondences found = track(image, image, points);
  CHECK(found.found == std::vector<std::uint8_t>{1, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1});
  CHECK(std::isnan(found.reference_px[1].x));
  check_shift(found, points, {0, 0}, 0.02F);
}

TEST_CASE("A point that leaves the image is not found") {
  const test::WaveTexture texture(7);
  const std::vector<cv::Point2f> points{{12, 100}, {160, 100}};
  const Correspondences found = track(texture.image(kSize), texture.image(kSize, {10, 0}), points);
  CHECK(found.found == std::vector<std::uint8_t>{0, 1});
}

TEST_CASE("Nothing to track, nothing to track in, and images of different size find nothing") {
  const cv::Mat image = test::WaveTexture(8).image(kSize);
  CHECK(track(image, image, {}).size() == 0);
  const std::vector<cv::Point2f> one{{60, 60}};
  const auto none = std::vector<std::uint8_t>{0};
  CHECK(track(image, cv::Mat(), one).found == none);
  CHECK(track(cv::Mat(), image, one).found == none);
  CHECK(track(image, image(cv::Rect(0, 0, 319, 240)), one).found == none);
  CHECK(track(cv::Mat(kSize, CV_8UC3, cv::Scalar::all(9)), image, one).found == none);
  CHECK(track(cv::Mat(kSize, CV_8UC1, cv::Scalar(9)), cv::Mat(kSize, CV_8UC1, cv::Scalar(9)), one).found ==
        none);
  const Correspondences all_nan = track(image, image, {{kNan, kNan}, {kNan, kNan}});
  CHECK(all_nan.count() == 0);
  CHECK(all_nan.size() == 2);
}

TEST_CASE("Images smaller than the window are survived") {
  for (const cv::Size size : {cv::Size(1, 1), {2, 30}, {15, 12}, {21, 21}, {40, 22}}) {
    const cv::Mat image = test::noise_image(size, 9, 0);
    FlowParams params;
    params.border_px = 0;
    const std::vector<cv::Point2f> points{
        {static_cast<float>(size.width - 1) / 2, static_cast<float>(size.height - 1) / 2}, {0, 0}};
    for (const FlowEngine engine : {FlowEngine::Own, FlowEngine::OpenCv}) {
      params.engine = engine;
      const Correspondences found = track(image, image, points, params);
      CHECK(found.size() == 2);
      check_shift(found, points, {0, 0}, 0.1F);
    }
  }
}

TEST_CASE("A guess reaches motions that the pyramid does not") {
  const test::WaveTexture texture(10);
  const cv::Size size(640, 480);
  const cv::Point2d shift(130, -90);
  const cv::Mat current = texture.image(size), reference = texture.image(size, shift);
  const auto points = test::random_points(size, 200, 160, 11);
  std::vector<cv::Point2f> guess;
  for (const cv::Point2f& p : points) guess.push_back(p - cv::Point2f(shift) + cv::Point2f(3, 2));
  for (const FlowCheck check : {FlowCheck::Residual, FlowCheck::ForwardBackward}) {
    const Correspondences blind = track(current, reference, points, with(check));
    const Correspondences led = track(current, reference, points, with(check), guess);
    CHECK(blind.count() < 40);
    CHECK(led.count() > 195);
    check_shift(led, points, shift, 0.1F);
  }
  std::vector<cv::Point2f> useless(points.size(), {kNan, kNan});
  CHECK(track(current, reference, points, {}, useless).found == track(current, reference, points).found);
  useless.pop_back();  // of the wrong length: ignored
  CHECK(track(current, reference, points, {}, useless).found == track(current, reference, points).found);
}

TEST_CASE("One and two threads give the same bits, and so does a second run with used buffers") {
  const cv::Size size(640, 480);
  const cv::Mat current = test::noise_image(size, 14, 1.5);
  cv::Mat reference;
  cv::GaussianBlur(test::noise_image(size, 14, 1.5), reference, {}, 0.8);
  const auto points = test::random_points(size, 700, 3, 15);
  const int threads = cv::getNumThreads();
  std::vector<Correspondences> runs(3);
  FlowTracker tracker(with(FlowCheck::ForwardBackward));
  ImagePyramid a, b;
  for (std::size_t run = 0; run < 3; ++run) {
    cv::setNumThreads(run == 1 ? 2 : 1);
    tracker.build(current, a);
    tracker.build(reference, b);
    tracker.track(a, b, points, {}, runs[run]);
  }
  cv::setNumThreads(threads);
  CHECK(runs[0].count() > 300);
  for (std::size_t run = 1; run < 3; ++run) {
    CHECK(runs[0].found == runs[run].found);
    CHECK(same_bits(runs[0].reference_px, runs[run].reference_px));
  }
}

TEST_CASE("Each point is tracked alone: order and company do not matter") {
  const test::WaveTexture texture(16);
  const cv::Mat current = texture.image(kSize), reference = texture.image(kSize, {2.3, 1.1});
  auto points = test::random_points(kSize, 100, 0, 17);
  const Correspondences forward = track(current, reference, points);
  std::reverse(points.begin(), points.end());
  points.insert(points.begin() + 50, {kNan, kNan});
  Correspondences backward = track(current, reference, points);
  CHECK(forward.count() > 60);
  for (std::size_t i = 0; i < 100; ++i) {
    const std::size_t j = 99 - i + (99 - i >= 50 ? 1 : 0);
    CHECK(forward.found[i] == backward.found[j]);
    if (forward.found[i] != 0) CHECK(forward.reference_px[i] == backward.reference_px[j]);
  }
}

TEST_CASE("Parameters are checked") {
  FlowParams params;
  params.window_px = 2;
  CHECK_THROWS_AS(FlowTracker{params}, ConfigError);
}

}  // namespace flow_test
