// SPDX-License-Identifier: MIT
#include <odometry/orb_extractor.hpp>

#include "doctest/doctest.h"
#include "test_images.hpp"

namespace orb_extractor_test {

using namespace dynfilter::odometry;

namespace {
int crowded(const std::vector<cv::KeyPoint>& keypoints) {
  int count = 0;
  for (std::size_t i = 0; i < keypoints.size(); ++i)
    for (std::size_t j = 0; j < keypoints.size(); ++j)
      if (i != j && keypoints[i].octave == keypoints[j].octave &&
          cv::norm(keypoints[i].pt - keypoints[j].pt) < 3) {
        ++count;
        break;
      }
  return count;
}
}  // namespace

TEST_CASE("features cover the image and do not crowd as cv::ORB's do") {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(100));
  image += odometry_test::texture({640, 480}, 1) / 8;                                 // weak everywhere
  odometry_test::texture({160, 120}, 2).copyTo(image(cv::Rect(200, 200, 160, 120)));  // strong in one place
  OrbExtractor extractor{ExtractorOptions{}};
  std::vector<cv::KeyPoint> keypoints;
  std::vector<Descriptor> descriptors;
  extractor.extract(image, keypoints, descriptors);
  REQUIRE(keypoints.size() == descriptors.size());
  CHECK(keypoints.size() >= 900);
  CHECK(keypoints.size() <= 1000);
  CHECK(crowded(keypoints) < 20);
  std::vector<cv::KeyPoint> opencv;
  cv::ORB::create(1000)->detect(image, opencv);
  CHECK(crowded(opencv) > 10 * std::max(1, crowded(keypoints)));
  int cells[4][5] = {}, octaves[8] = {};
  for (const auto& k : keypoints) {
    ++cells[static_cast<int>(k.pt.y / 120)][static_cast<int>(k.pt.x / 128)];
    ++octaves[k.octave];
  }
  for (const auto& row : cells)
    for (const int count : row) CHECK(count >= 10);
  for (int level = 0; level < 8; ++level) CHECK(octaves[level] > 20);
}

TEST_CASE("an image that is turned by a right angle has the same features, turned") {
  const cv::Mat image = odometry_test::texture({400, 400}, 3);
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  ExtractorOptions options;
  options.levels = 1;
  options.features = 100000;  // all: which ones are chosen depends on ties
  OrbExtractor extractor(options);
  std::vector<cv::KeyPoint> a, b;
  std::vector<Descriptor> da, db;
  extractor.extract(image, a, da);
  extractor.extract(turned, b, db);
  int found = 0, alike = 0, angle = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const cv::Point2f place(399 - a[i].pt.y, a[i].pt.x);
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (cv::norm(b[j].pt - place) > 0.1) continue;
      ++found;
      alike += hamming(da[i], db[j]) < 40;
      const double difference = std::fmod(b[j].angle - a[i].angle + 720.0, 360.0);
      angle += std::abs(difference - 90.0) < 1.0;
    }
  }
  CHECK(found > 0.8 * static_cast<double>(a.size()));
  CHECK(alike > 0.95 * found);
  CHECK(angle > 0.99 * found);
}

TEST_CASE("images without corners or without room give none") {
  OrbExtractor extractor{ExtractorOptions{}};
  std::vector<cv::KeyPoint> keypoints;
  std::vector<Descriptor> descriptors;
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(30, 30), cv::Size(41, 480), cv::Size(1, 1)}) {
    extractor.extract(cv::Mat(size, CV_8UC1, cv::Scalar(90)), keypoints, descriptors);
    CHECK(keypoints.empty());
    CHECK(descriptors.empty());
  }
  extractor.extract(odometry_test::texture({96, 80}, 4), keypoints, descriptors);
  CHECK(keypoints.size() > 20);
  for (const auto& k : keypoints) CHECK((k.pt.x >= 0 && k.pt.y >= 0 && k.pt.x < 96 && k.pt.y < 80));
}

}  // namespace orb_extractor_test
