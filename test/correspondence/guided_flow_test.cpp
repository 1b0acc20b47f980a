// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstring>
#include <dynfilter/correspondence/guided_flow.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace guided_flow_test {

using namespace dynfilter;

namespace {

using Points = std::vector<cv::Point2f>;
using Motion = std::function<cv::Point2f(const cv::Point2f&)>;

const cv::Size kSize(640, 480);

struct Tracked {
  Points px;
  std::vector<std::uint8_t> status;
  std::vector<MatchSpread> spread;
  long count() const { return std::count(status.begin(), status.end(), std::uint8_t{1}); }
};

Tracked track(const cv::Mat& from, const cv::Mat& to, const Points& points, const Points& guess = {},
              FlowCheck check = FlowCheck::ForwardBackward) {
  const FlowParams params = FlowParams::guided();
  ImagePyramid a, b;
  a.build(from, params.window_px, params.levels, false);
  b.build(to, params.window_px, params.levels, false);
  Tracked out{guess.empty() ? points : guess, {}, {}};
  GuidedFlow(params, 1).track(a, b, check, points, out.px, out.status, out.spread);
  return out;
}

/// The image in which each pixel of `image` has moved to motion(pixel).
cv::Mat moved(const cv::Mat& image, const Motion& inverse) {
  cv::Mat map(image.size(), CV_32FC2), out;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      map.at<cv::Point2f>(y, x) = inverse({static_cast<float>(x), static_cast<float>(y)});
  cv::remap(image, out, map, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_REFLECT_101);
  return out;
}

float apart(const cv::Point2f& a, const cv::Point2f& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// Distances of the found points from their true positions.
std::vector<float> errors(const Tracked& found, const Points& points, const Motion& motion) {
  std::vector<float> out;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (found.status[i] != 0) out.push_back(apart(found.px[i], motion(points[i])));
  std::sort(out.begin(), out.end());
  return out;
}

Motion shift_by(float x, float y) {
  return [=](const cv::Point2f& p) { return p + cv::Point2f(x, y); };
}

/// A mover of other texture before a background. Its corner is at (240, 180) in the current image.
struct MoverScene {
  cv::Rect mover{240, 180, 140, 120};
  cv::Point2f background_flow, mover_flow;
  cv::Mat current, reference;

  MoverScene(const cv::Point2f& background, const cv::Point2f& own, unsigned seed = 20)
      : background_flow(background), mover_flow(own) {
    const test::WaveTexture far = test::WaveTexture::broad(seed), near = test::WaveTexture::broad(seed + 1);
    current = far.image(kSize);
    reference = far.image(kSize, -cv::Point2d(background));
    near.image(mover.size()).copyTo(current(mover));
    // Whole pixels, so that the mover's texture is the same.
    near.image(mover.size()).copyTo(reference(mover + cv::Point(own)));
  }
  Points points_on_mover(int margin_px) const {
    Points points;
    for (int y = mover.y + margin_px; y <= mover.br().y - margin_px; y += 9)
      for (int x = mover.x + margin_px; x <= mover.br().x - margin_px; x += 9)
        points.emplace_back(static_cast<float>(x), static_cast<float>(y));
    return points;
  }
};

}  // namespace

TEST_CASE("Shifts from a fraction of a pixel to 40 px are found to a tenth of a pixel") {
  const test::WaveTexture texture = test::WaveTexture::broad(1);
  const cv::Mat current = texture.image(kSize);
  const Points points = test::random_points(kSize, 500, 60, 2);
  for (const cv::Point2f shift :
       {cv::Point2f(0, 0), {0.37F, -0.61F}, {3.25F, 2.5F}, {-17.6F, 9.2F}, {40, -31.5F}}) {
    CAPTURE(shift);
    const Tracked found = track(current, texture.image(kSize, -cv::Point2d(shift)), points);
    CHECK(found.count() >= 495);
    CHECK(errors(found, points, shift_by(shift.x, shift.y)).back() < 0.1F);
  }
}

TEST_CASE("A shaken camera: 8 degrees of roll and 25 px at once") {
  const cv::Mat current = test::WaveTexture::broad(3).image(kSize);
  const float c = std::cos(0.14F), s = std::sin(0.14F);
  const cv::Point2f centre(320, 240), jump(25, -12);
  const Motion motion = [&](const cv::Point2f& p) {
    const cv::Point2f d = p - centre;
    return cv::Point2f(c * d.x - s * d.y, s * d.x + c * d.y) + centre + jump;
  };
  const Motion inverse = [&](const cv::Point2f& p) {
    const cv::Point2f d = p - centre - jump;
    return cv::Point2f(c * d.x + s * d.y, c * d.y - s * d.x) + centre;
  };
  const Points points = test::random_points(kSize, 500, 110, 4);
  const Tracked found = track(current, moved(current, inverse), points);
  CHECK(found.count() >= 480);
  const std::vector<float> off = errors(found, points, motion);
  CHECK(off[off.size() / 2] < 0.35F);  // the patch turns by up to 1 px at its edge
  CHECK(off[off.size() * 99 / 100] < 1.0F);
}

TEST_CASE("A mover is not drawn to the background's flow, wherever its points start") {
  // From a mover just beside the predicted place to one that is far away.
  for (const cv::Point2f own : {cv::Point2f(2, 0), {0, -3}, {5, 4}, {-9, 6}, {14, -11}, {24, 18}})
    for (const cv::Point2f background : {cv::Point2f(0, 0), {12, 5}}) {
      const MoverScene scene(background, background + own);
      const Points points = scene.points_on_mover(10);
      Points predicted;
      for (const cv::Point2f& p : points) predicted.push_back(p + background);
      for (const Points& guess : {Points(), predicted}) {
        CAPTURE(own);
        CAPTURE(background);
        CAPTURE(guess.size());
        const Tracked found = track(scene.current, scene.reference, points, guess);
        CHECK(found.count() >= static_cast<long>(points.size() * 19 / 20));
        std::size_t like_background = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
          if (found.status[i] != 0 && apart(found.px[i], points[i] + background) < 1) ++like_background;
        CHECK(like_background == 0);
        const std::vector<float> off =
            errors(found, points, shift_by(scene.mover_flow.x, scene.mover_flow.y));
        CHECK(off[off.size() * 95 / 100] < 0.1F);
      }
    }
}

TEST_CASE("The background beside a mover keeps its own flow, and what is covered is not found") {
  const MoverScene scene({6, 3}, {-44, 29});
  const cv::Rect now = scene.mover, then = scene.mover + cv::Point(scene.mover_flow);
  Points beside, covered;
  for (const cv::Point2f& p : test::random_points(kSize, 6000, 40, 6)) {
    const cv::Point2f at = p + scene.background_flow;
    const auto gap = [](const cv::Rect& r, const cv::Point2f& q) {
      const cv::Point2f a = cv::Point2f(r.tl()), b = cv::Point2f(r.br());
      return std::max(std::max(a.x - q.x, q.x - b.x), std::max(a.y - q.y, q.y - b.y));
    };
    if (gap(now, p) > 10 && gap(then, at) > 10 && std::min(gap(now, p), gap(then, at)) < 30)
      beside.push_back(p);
    if (gap(now, p) > 10 && gap(then, at) < -10) covered.push_back(p);
  }
  REQUIRE(beside.size() > 100);
  REQUIRE(covered.size() > 15);
  const Tracked found = track(scene.current, scene.reference, beside);
  CHECK(found.count() >= static_cast<long>(beside.size() * 19 / 20));
  const std::vector<float> off = errors(found, beside, shift_by(6, 3));
  CHECK(off[off.size() * 98 / 100] < 0.1F);
  CHECK(track(scene.current, scene.reference, covered).count() <= static_cast<long>(covered.size() / 10));
}

TEST_CASE("Repeated texture is matched to one of its repetitions, and to the guess's") {
  // Period 20 px in both directions: longer than the patch, so a patch is unique within one period.
  const auto tiles = [](cv::Point2f shift) {
    cv::Mat image(kSize, CV_8UC1);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) {
        const double u = (static_cast<double>(x) - shift.x) * 2 * CV_PI / 20,
                     v = (static_cast<double>(y) - shift.y) * 2 * CV_PI / 20;
        image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(
            128 + 50 * std::sin(u) + 40 * std::sin(v) + 30 * std::sin(u + v));
      }
    return image;
  };
  const Points points = test::random_points(kSize, 300, 60, 7);
  const cv::Point2f shift(6, -4);
  const cv::Mat current = tiles({}), reference = tiles(shift);
  const auto from_period = [](float v) { return std::abs(std::remainder(v, 20.0F)); };
  const Tracked blind = track(current, reference, points);
  CHECK(blind.count() >= 290);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (blind.status[i] == 0) continue;
    const cv::Point2f off = blind.px[i] - points[i] - shift;
    CHECK(from_period(off.x) < 0.1F);
    CHECK(from_period(off.y) < 0.1F);
  }
  Points guess;
  for (const cv::Point2f& p : points) guess.push_back(p + shift + cv::Point2f(1, 1));
  const Tracked led = track(current, reference, points, guess);
  CHECK(led.count() >= 290);
}

TEST_CASE("A blurred frame and a step of the exposure cost accuracy, not the points") {
  const test::WaveTexture texture = test::WaveTexture::broad(8);
  const cv::Mat current = texture.image(kSize);
  const cv::Mat sharp = texture.image(kSize, {-5.5, 3.25});
  const Points points = test::random_points(kSize, 400, 30, 9);
  cv::Mat blurred, brighter;
  cv::blur(sharp, blurred, {5, 1});  // 5 px of motion in the exposure
  const Tracked in_blur = track(current, blurred, points);
  CHECK(in_blur.count() >= 340);
  const std::vector<float> blur_errors = errors(in_blur, points, shift_by(5.5F, -3.25F));
  CHECK(blur_errors[blur_errors.size() / 2] < 0.3F);
  CHECK(blur_errors[blur_errors.size() * 95 / 100] < 1.0F);
  sharp.convertTo(brighter, CV_8U, 0.7, 60);
  const Tracked in_light = track(current, brighter, points);
  CHECK(in_light.count() >= 395);
  const std::vector<float> light_errors = errors(in_light, points, shift_by(5.5F, -3.25F));
  CHECK(light_errors[light_errors.size() / 2] < 0.2F);
  CHECK(light_errors[light_errors.size() * 95 / 100] < 0.5F);
}

TEST_CASE("Between unrelated images the checks accept less than 2 %") {
  const Points points = test::random_points(kSize, 1000, 20, 10);
  for (const double sigma_px : {0.0, 1.5, 3.0}) {
    CAPTURE(sigma_px);
    const cv::Mat a = test::noise_image(kSize, 11, sigma_px), b = test::noise_image(kSize, 12, sigma_px);
    CHECK(track(a, b, points).count() < 20);
    CHECK(track(a, b, points, {}, FlowCheck::None).count() > 700);
  }
}

TEST_CASE("Wider instructions and more threads give the same bits, in every window and at borders") {
  const cv::Size size(201, 158);
  const test::WaveTexture texture(13);
  for (int window_px = 3; window_px <= 20; ++window_px) {
    if (!GuidedFlow::supports(window_px)) continue;
    FlowParams params = FlowParams::guided();
    params.window_px = window_px;
    const auto w = static_cast<unsigned>(window_px);
    for (const bool noise : {false, true}) {
      ImagePyramid a, b;
      a.build(noise ? test::noise_image(size, w, 1) : texture.image(size), window_px, 4, false);
      b.build(noise ? test::noise_image(size, w, 1.2) : texture.image(size, {2.6, -1.3}), window_px, 4,
              false);
      const Points points = test::random_points(size, 200, 0, w);
      std::vector<Tracked> runs(3, {points, {}, {}});
      for (std::size_t run = 0; run < 3; ++run) {
        GuidedFlow flow(params, run == 2 ? 2 : 1);
        flow.wide = run != 1;
        flow.track(a, b, FlowCheck::ForwardBackward, points, runs[run].px, runs[run].status,
                   runs[run].spread);
      }
      CHECK(runs[0].count() > 50);
      for (std::size_t run = 1; run < 3; ++run) {
        CHECK(runs[run].status == runs[0].status);
        CHECK(std::memcmp(runs[run].px.data(), runs[0].px.data(), points.size() * sizeof(points[0])) == 0);
      }
    }
  }
}

TEST_CASE("Flat images, wild positions and other pyramids are lost, not followed") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const cv::Mat image = test::noise_image({100, 80}, 5, 1), flat(80, 100, CV_8UC1, cv::Scalar(200));
  CHECK(track(flat, image, {{50, 40}}).count() == 0);
  const Points wild{{nan, 40}, {50, inf}, {-1e30F, 40}, {3e9F, 40}, {-50, 40}, {50, 200}, {50, 40}};
  const std::vector<std::uint8_t> only_last{0, 0, 0, 0, 0, 0, 1};
  CHECK(track(image, image, wild).status == only_last);
  const Points from(wild.size(), {50, 40});
  const Tracked led = track(image, image, from, wild);  // the grid leads there without the guess
  CHECK(led.count() == static_cast<long>(wild.size()));
  CHECK(track(image, test::noise_image({101, 80}, 5, 1), {{50, 40}}).count() == 0);
}

TEST_CASE("a match on stripes slides along them, one on corners does not slide") {
  for (const double angle : {0.0, 0.4, 1.2, 2.5}) {
    cv::Mat stripes(kSize, CV_8UC1);
    const cv::Point2d edge(std::cos(angle), std::sin(angle));
    for (int y = 0; y < kSize.height; ++y)
      for (int x = 0; x < kSize.width; ++x)
        stripes.at<unsigned char>(y, x) =
            static_cast<unsigned char>(128 + 100 * std::sin(0.35 * (edge.x * y - edge.y * x)));
    cv::Mat noise(kSize, CV_8UC1);
    cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 9);  // a patch without any texture along is not tracked
    const Tracked found = track(stripes + noise, stripes + noise, {{200, 200}, {301, 142}});
    for (std::size_t i = 0; i < 2; ++i) {
      REQUIRE(found.status[i] != 0);
      CHECK(found.spread[i].along > 100.0F);
      CHECK(std::abs(cv::Point2d(found.spread[i].edge).dot(edge)) > 0.999);
    }
  }
  const cv::Mat corners = test::WaveTexture::broad(3).image(kSize);
  const Tracked found = track(corners, corners, test::random_points(kSize, 200, 30, 4));
  CHECK(std::count_if(found.spread.begin(), found.spread.end(),
                      [](const MatchSpread& s) { return s.slides(); }) < 40);
}

}  // namespace guided_flow_test
