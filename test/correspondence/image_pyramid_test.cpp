// SPDX-License-Identifier: MIT
#include <dynfilter/correspondence/image_pyramid.hpp>

#include "correspondence/random_texture.hpp"
#include "doctest/doctest.h"

namespace image_pyramid_test {

using namespace dynfilter;

namespace {

std::vector<const unsigned char*> addresses(const ImagePyramid& pyramid) {
  std::vector<const unsigned char*> result;
  for (const cv::Mat& level : pyramid.levels()) result.push_back(level.datastart);
  return result;
}

bool equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

}  // namespace

TEST_CASE("A pyramid owns its pixels") {
  cv::Mat image = test::noise_image({320, 240}, 1, 0);
  const cv::Mat before = image.clone();
  ImagePyramid pyramid;
  CHECK(pyramid.empty());
  pyramid.build(image, 21, 3);
  image.setTo(0);
  CHECK(equal(pyramid.image(), before));
  CHECK(pyramid.size() == cv::Size(320, 240));
  CHECK(pyramid.levels().size() == 8);  // four images, each with its derivatives
}

TEST_CASE("Building again allocates nothing and gives what a fresh one gives") {
  ImagePyramid pyramid, fresh;
  pyramid.build(test::noise_image({320, 240}, 1, 0), 21, 3);
  const auto first = addresses(pyramid);
  pyramid.clear();
  CHECK(pyramid.empty());
  const cv::Mat image = test::noise_image({320, 240}, 2, 0);
  pyramid.build(image, 21, 3);
  CHECK(addresses(pyramid) == first);
  fresh.build(image, 21, 3);
  CHECK(pyramid.fits(fresh));
  for (std::size_t i = 0; i < fresh.levels().size(); ++i)
    CHECK(equal(pyramid.levels()[i], fresh.levels()[i]));
}

TEST_CASE("A region of a larger image does not look at the pixels around it") {
  const cv::Mat large = test::noise_image({400, 300}, 3, 0);
  const cv::Mat region = large(cv::Rect(40, 30, 320, 240));
  ImagePyramid of_region, of_copy;
  of_region.build(region, 21, 3);
  of_copy.build(region.clone(), 21, 3);
  for (std::size_t i = 0; i < of_copy.levels().size(); i += 2) {
    cv::Mat a = of_region.levels()[i], b = of_copy.levels()[i];
    a.adjustROI(21, 21, 21, 21);
    b.adjustROI(21, 21, 21, 21);
    CHECK(equal(a, b));
  }
}

TEST_CASE("The size may change, shrink and come back") {
  ImagePyramid pyramid;
  for (const cv::Size size : {cv::Size(320, 240), {30, 20}, {1, 1}, {321, 239}, {320, 240}}) {
    const cv::Mat image = test::noise_image(size, 4, 0);
    pyramid.build(image, 21, 3);
    CHECK(equal(pyramid.image(), image));
  }
}

TEST_CASE("What is not a grey image leaves it empty") {
  ImagePyramid pyramid;
  for (const cv::Mat& image : {cv::Mat(), cv::Mat(20, 20, CV_8UC3), cv::Mat(20, 20, CV_16UC1)}) {
    pyramid.build(test::noise_image({64, 64}, 5, 0), 21, 2);
    CHECK_FALSE(pyramid.empty());
    pyramid.build(image, 21, 2);
    CHECK(pyramid.empty());
    CHECK(pyramid.image().empty());
    CHECK_FALSE(pyramid.fits(pyramid));
  }
}

TEST_CASE("Swapping and moving hand over the memory") {
  ImagePyramid a, b;
  a.build(test::noise_image({64, 64}, 6, 0), 21, 1);
  const auto memory = addresses(a);
  std::swap(a, b);
  CHECK(a.empty());
  CHECK(addresses(b) == memory);
  CHECK_FALSE(a.fits(b));
}

}  // namespace image_pyramid_test
