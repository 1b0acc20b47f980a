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

// OpenCV's pyramid is the twin. Sizes around the width of vectors, odd ones, and a white image, whose sums
// are the largest.
TEST_CASE("Without derivatives the images and borders are OpenCV's, and building again allocates nothing") {
  ImagePyramid pyramid;
  for (const int window_px : {3, 16, 21})
    for (const cv::Size size :
         {cv::Size(640, 480), {1, 1}, {7, 9}, {61, 83}, {66, 34}, {129, 257}, {752, 480}}) {
      CAPTURE(window_px);
      CAPTURE(size);
      const cv::Mat large = test::noise_image(size + cv::Size(9, 5), 7, 0);
      const cv::Mat images[] = {large(cv::Rect({4, 3}, size)), cv::Mat(size, CV_8UC1, cv::Scalar(255))};
      std::vector<const unsigned char*> first;
      for (const cv::Mat& image : images) {
        pyramid.build(image, window_px, 4, false);
        std::vector<cv::Mat> twin;
        cv::buildOpticalFlowPyramid(image, twin, {window_px, window_px}, 4, false,
                                    cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED, cv::BORDER_CONSTANT, false);
        REQUIRE(pyramid.levels().size() == twin.size());
        for (std::size_t k = 0; k < twin.size(); ++k) {
          cv::Mat ours = pyramid.levels()[k], theirs = twin[k];
          ours.adjustROI(window_px, window_px, window_px, window_px);
          theirs.adjustROI(window_px, window_px, window_px, window_px);
          CHECK(equal(ours, theirs));
        }
        if (first.empty()) first = addresses(pyramid);
        CHECK(addresses(pyramid) == first);
      }
    }
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
