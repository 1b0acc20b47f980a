// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/small_patch_kernels.hpp>
#include <dynfilter/correspondence/small_window.hpp>
#include <limits>
#include <opencv2/core.hpp>

#include "correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace small_window_test {

using namespace dynfilter;
using detail::SmallCorner;
using detail::SmallPatch;

namespace {

constexpr int kWindows[] = {12, 13, 14, 15, 16};

int grey(const cv::Mat& image, int x, int y) {
  return *detail::pixel(image, x, y);
}
bool inside(const cv::Mat& image, int x, int y) {
  return cv::Rect(0, 0, image.cols, image.rows).contains({x, y});
}
/// (1 3 1) across, right - left, and 0 outside of the image.
int gradient_x(const cv::Mat& image, int x, int y) {
  int sum = 0;
  for (int k = -1; k <= 1; ++k)
    sum += (k == 0 ? 3 : 1) * (grey(image, x + 1, y + k) - grey(image, x - 1, y + k));
  return inside(image, x, y) ? sum : 0;
}
int gradient_y(const cv::Mat& image, int x, int y) {
  int sum = 0;
  for (int k = -1; k <= 1; ++k)
    sum += (k == 0 ? 3 : 1) * (grey(image, x + k, y + 1) - grey(image, x + k, y - 1));
  return inside(image, x, y) ? sum : 0;
}
/// Between four pixels, as the kernels round: down, to 1/128 and then to 1/8 grey level.
int between(const cv::Mat& image, const SmallCorner& corner, int x, int y) {
  const auto row = [&](int r) {
    const int left = grey(image, corner.x + x, corner.y + r);
    return left * 128 + (grey(image, corner.x + x + 1, corner.y + r) - left) * corner.u;
  };
  const int upper = row(y), lower = row(y + 1);
  return (upper >> 4) + static_cast<int>(std::floor((lower - upper) * corner.v / 65536.0));
}

template <class Kernels>
void check_sums(const cv::Mat& image, const cv::Mat& other, int x0, int y0, int window_px) {
  SmallPatch patch;
  Kernels::cut(image, x0, y0, window_px, patch);
  const SmallCorner corner(cv::Point2f(static_cast<float>(x0) + 1.37F, static_cast<float>(y0) - 0.81F));
  const detail::SmallPatchMismatch mismatch = Kernels::mismatch(other, corner, window_px, patch);
  const detail::SmallPatchLikeness likeness = Kernels::likeness(other, corner, window_px, patch);
  const cv::Point whole(x0 + 2, y0 - 1);
  const detail::SmallPatchDifference difference =
      Kernels::difference(other, whole.x, whole.y, window_px, patch);
  SmallPatch sums;
  std::int64_t whole_sum = 0, whole_square = 0;
  std::int64_t off_x = 0, off_y = 0, off_sum = 0, product = 0;
  std::int64_t grey_sum = 0, grey_square = 0, there_sum = 0, there_square = 0;
  for (int y = 0; y < window_px; ++y)
    for (int x = 0; x < window_px; ++x) {
      const int dx = gradient_x(image, x0 + x, y0 + y), dy = gradient_y(image, x0 + x, y0 + y);
      const int value = 8 * grey(image, x0 + x, y0 + y), there = between(other, corner, x, y),
                off = there - value;
      sums.x += dx, sums.y += dy, sums.xx += dx * dx, sums.xy += dx * dy, sums.yy += dy * dy;
      grey_sum += value, grey_square += value * value, there_sum += there, there_square += there * there;
      const int whole_off = 8 * grey(other, whole.x + x, whole.y + y) - value;
      whole_sum += whole_off, whole_square += whole_off * whole_off;
      off_x += off * dx, off_y += off * dy, off_sum += off, product += there * value;
    }
  CHECK(patch.x == sums.x);
  CHECK(patch.y == sums.y);
  CHECK(patch.xx == sums.xx);
  CHECK(patch.xy == sums.xy);
  CHECK(patch.yy == sums.yy);
  CHECK(mismatch.x == off_x);
  CHECK(mismatch.y == off_y);
  CHECK(mismatch.sum == off_sum);
  CHECK(likeness.patch == grey_sum);
  CHECK(likeness.patch2 == grey_square);
  CHECK(likeness.image == there_sum);
  CHECK(likeness.image2 == there_square);
  CHECK(likeness.product == product);
  CHECK(difference.sum == whole_sum);
  CHECK(difference.square == whole_square);
}

cv::Mat bordered(const cv::Mat& image, ImagePyramid& pyramid, int window_px) {
  pyramid.build(image, window_px, 0, false);
  return pyramid.image();
}

}  // namespace

TEST_CASE("All sums of the kernels are those of a loop over the pixels, across the image's border too") {
  const cv::Size size(60, 50);
  for (const int window_px : kWindows) {
    ImagePyramid a, b;
    const auto w = static_cast<unsigned>(window_px);
    const cv::Mat from = bordered(test::noise_image(size, w, 0), a, window_px);
    const cv::Mat to = bordered(test::noise_image(size, w + 100, 0), b, window_px);
    for (const cv::Point corner : {cv::Point(20, 17), {-5, 3}, {50, 40}, {7, -6}, {-4, 42}}) {
      check_sums<detail::SmallPatchKernels<8>>(from, to, corner.x, corner.y, window_px);
      if (uses_avx2()) check_sums<detail::SmallPatchKernels<16>>(from, to, corner.x, corner.y, window_px);
    }
  }
}

TEST_CASE("Sums of the most extreme pixels fit 32 bits") {
  // Stripes of period four have the largest gradient at every pixel.
  cv::Mat stripes(60, 60, CV_8UC1), inverted;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) stripes.at<unsigned char>(y, x) = x % 4 < 2 ? 0 : 255;
  cv::bitwise_not(stripes, inverted);
  ImagePyramid a, b;
  const cv::Mat from = bordered(stripes, a, 16), to = bordered(inverted, b, 16);
  check_sums<detail::SmallPatchKernels<8>>(from, to, 20, 20, 16);
  check_sums<detail::SmallPatchKernels<8>>(from.t(), to.t(), 20, 20, 16);
  if (uses_avx2()) check_sums<detail::SmallPatchKernels<16>>(from, to, 20, 20, 16);
}

TEST_CASE("A patch is found at its place, at the borders and with another exposure too") {
  const test::WaveTexture texture(4);
  const cv::Size size(160, 120);
  const cv::Point2d shift(1.3, -0.7);
  for (const int window_px : kWindows) {
    ImagePyramid a, b;
    cv::Mat dark, bright;
    texture.image(size).convertTo(dark, CV_8U, 0.7, 10);
    texture.image(size, shift).convertTo(bright, CV_8U, 0.7, 60);
    const cv::Mat from = bordered(dark, a, window_px), to = bordered(bright, b, window_px);
    detail::SmallWindow<detail::SmallPatchKernels<8>> window(window_px);
    for (const cv::Point2f& px : test::random_points(size, 60, 12, 8)) {
      REQUIRE(window.cut(from, px));
      REQUIRE(window.textured(1e-4));
      cv::Point2f at = px;
      REQUIRE(window.refine(to, 20, 0.01F, at));
      CHECK(std::hypot(at.x - px.x + 1.3F, at.y - px.y - 0.7F) < 0.1F);
      CHECK(window.residual(to, at) < 0.05);
      CHECK(window.difference(to, at) < window.difference(to, px));
    }
  }
}

TEST_CASE("Every place is within the border or refused, on images of any size") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const int window_px : kWindows)
    for (const cv::Size size : {cv::Size(1, 1), {5, 40}, {40, 30}}) {
      ImagePyramid a;
      const cv::Mat image = bordered(test::noise_image(size, 3, 0), a, window_px);
      detail::SmallWindow<detail::SmallPatchKernels<8>> window(window_px);
      detail::SmallWindow<detail::SmallPatchKernels<16>> wide(window_px);
      int readable = 0;
      // The sanitizers check what is read.
      for (float y = -30; y < 70; y += 0.5F)
        for (float x = -30; x < 70; x += 0.5F) {
          readable += window.cut(image, {x, y}) ? 1 : 0;
          if (uses_avx2()) wide.cut(image, {x, y});
          CHECK(window.residual(image, {x, y}) >= 0);
          if (uses_avx2()) CHECK(wide.residual(image, {x, y}) >= 0);
        }
      CHECK(readable > 0);
      CHECK_FALSE(window.cut(image, {nan, 3}));
      CHECK_FALSE(window.cut(image, {3, -1e30F}));
    }
}

TEST_CASE("A flat patch and a straight edge have too little texture") {
  cv::Mat edge(60, 60, CV_8UC1, cv::Scalar(50));
  edge.colRange(30, 60).setTo(200);
  ImagePyramid a, b;
  detail::SmallWindow<detail::SmallPatchKernels<8>> window(16);
  REQUIRE(window.cut(bordered(edge, a, 16), {30, 30}));
  CHECK_FALSE(window.textured(1e-4));
  REQUIRE(window.cut(bordered(cv::Mat(60, 60, CV_8UC1, cv::Scalar(90)), b, 16), {30, 30}));
  CHECK_FALSE(window.textured(1e-4));
  CHECK(window.residual(b.image(), {30, 30}) == 1);
}

}  // namespace small_window_test
