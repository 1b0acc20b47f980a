// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/patch_residual.hpp>

#include "correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace patch_residual_test {

using namespace dynfilter;

namespace {

const cv::Size kSize(160, 120);

ImagePyramid pyramid_of(const cv::Mat& image, int window_px = 21) {
  ImagePyramid pyramid;
  pyramid.build(image, window_px, 0);
  return pyramid;
}

// Reference implementation: the definition in double, on the same rows.
double twin(const test::WaveTexture& texture, cv::Point2f a, cv::Point2f b) {
  std::vector<double> va, vb;
  for (int y = -10; y <= 10; y += 2)
    for (int x = -10; x <= 10; ++x) {
      va.push_back(std::clamp(texture(a.x + static_cast<float>(x), a.y + static_cast<float>(y)), 0.0, 255.0));
      vb.push_back(std::clamp(texture(b.x + static_cast<float>(x), b.y + static_cast<float>(y)), 0.0, 255.0));
    }
  const auto n = static_cast<double>(va.size());
  double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < va.size(); ++i) ma += va[i] / n, mb += vb[i] / n;
  for (std::size_t i = 0; i < va.size(); ++i) {
    aa += (va[i] - ma) * (va[i] - ma);
    bb += (vb[i] - mb) * (vb[i] - mb);
    ab += (va[i] - ma) * (vb[i] - mb);
  }
  return 1 - ab / std::sqrt(aa * bb);
}

}  // namespace

TEST_CASE("A patch is like itself, under any brightness and contrast, and unlike its inverse") {
  const cv::Mat image = test::WaveTexture(1).image(kSize) * 0.6 + 20;
  cv::Mat dimmed, inverse;
  image.convertTo(dimmed, CV_8U, 0.5, 60);
  image.convertTo(inverse, CV_8U, -1, 255);
  const ImagePyramid a = pyramid_of(image), b = pyramid_of(dimmed), c = pyramid_of(inverse);
  PatchResidual residual(21);
  for (const cv::Point2f& p : test::random_points(kSize, 50, 0, 2)) {
    CHECK(residual(a.image(), p, a.image(), p) == doctest::Approx(0).epsilon(1e-9));
    CHECK(residual(a.image(), p, b.image(), p) < 0.01);
    CHECK(residual(a.image(), p, c.image(), p) > 1.99);
  }
}

TEST_CASE("It is 1 - NCC of the texture between the pixels") {
  const test::WaveTexture texture(3);
  const ImagePyramid a = pyramid_of(texture.image(kSize));
  PatchResidual residual(21);
  const auto p = test::random_points(kSize, 60, 12, 4), q = test::random_points(kSize, 60, 12, 5);
  for (std::size_t i = 0; i < p.size(); ++i)
    CHECK(std::abs(residual(a.image(), p[i], a.image(), q[i]) - twin(texture, p[i], q[i])) < 0.03);
}

TEST_CASE("A flat patch is like nothing, and the corners of the image can be read") {
  const ImagePyramid flat = pyramid_of(cv::Mat(kSize, CV_8UC1, cv::Scalar(255)), 63);
  const ImagePyramid other = pyramid_of(test::noise_image(kSize, 6, 1), 63);
  for (const int window_px : {5, 20, 63}) {
    PatchResidual residual(window_px);
    for (const cv::Point2f& p : {cv::Point2f(0, 0), {159, 119}, {0, 119}, {80, 60.5F}}) {
      CHECK(residual(flat.image(), p, other.image(), p) == 1);
      CHECK(residual(flat.image(), p, flat.image(), p) == 1);
      CHECK(residual(other.image(), p, other.image(), p) == doctest::Approx(0));
    }
  }
}

}  // namespace patch_residual_test
