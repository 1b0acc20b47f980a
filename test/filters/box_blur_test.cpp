// SPDX-License-Identifier: MIT
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/random.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/box_blur.hpp>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "grid_scene.hpp"

namespace box_blur_test {

using namespace dynfilter;

namespace {

cv::Mat noise() {
  Random random(1, 1);
  cv::Mat image(110, 110, CV_8UC1);
  for (int y = 0; y < 110; ++y)
    for (int x = 0; x < 110; ++x) image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random.below(256));
  cv::blur(image.clone(), image, cv::Size(3, 3));
  return image;
}
Votes judge(const GridScene& scene, const cv::Mat& grey, const BoxBlurParams& params = {}) {
  FrameView frame = scene.view();
  frame.grey = grey;
  BoxBlurFilter filter(params);
  FrameEvidence evidence;
  return votes_of(filter, evidence, frame);
}

}  // namespace

TEST_CASE("a box that is blurred moves, a sharp one does not, nothing is said elsewhere") {
  GridScene scene;
  scene.boxes = {GridScene::detection(5, 5, 50, 50), GridScene::detection(65, 65, 40, 40)};
  cv::Mat grey = noise(), part = grey(cv::Rect(5, 5, 50, 50));
  CHECK(judge(scene, grey).count(Vote::Static) == 25 + 9);
  cv::blur(part.clone(), part, cv::Size(9, 1));
  const Votes votes = judge(scene, grey);
  CHECK(votes.count(Vote::Dynamic) == 25);
  CHECK(votes[scene.at(30, 30)] == Vote::Dynamic);
  CHECK(votes[scene.at(80, 80)] == Vote::Static);
  CHECK(votes[scene.at(80, 20)] == Vote::Unknown);
  CHECK(votes.suspicion(scene.at(30, 30)) > 0.5F);
  CHECK(votes.suspicion(scene.at(80, 80)) < 0.5F);
  cv::blur(grey.clone(), grey, cv::Size(9, 9));  // the whole image is blurred
  CHECK(judge(scene, grey).count(Vote::Dynamic) == 0);
}

TEST_CASE("no texture, nothing beside the boxes, boxes and images that are none: unknown") {
  GridScene scene;
  scene.boxes = {GridScene::detection(5, 5, 50, 50)};
  CHECK(judge(scene, cv::Mat(110, 110, CV_8UC1, cv::Scalar(90))).count(Vote::Unknown) == 81);
  cv::Mat smooth = noise();
  smooth(cv::Rect(5, 5, 50, 50)).setTo(90);
  CHECK(judge(scene, smooth).count(Vote::Unknown) == 81);
  CHECK(judge(scene, cv::Mat(3, 3, CV_8UC1, cv::Scalar(9))).count(Vote::Unknown) == 81);
  CHECK(judge(scene, cv::Mat(110, 110, CV_8UC3, cv::Scalar::all(9))).count(Vote::Unknown) == 81);
  scene.boxes = {GridScene::detection(0, 0, 110, 110)};
  CHECK(judge(scene, noise()).count(Vote::Unknown) == 81);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scene.boxes = {GridScene::detection(500, 500, 50, 50), GridScene::detection(60, 60, -20, -20),
                 GridScene::detection(nan, 0, 50, 50), GridScene::detection(5, 5, 50, 50, "tv"),
                 GridScene::detection(5, 5, 50, 50, "person", 0.1F)};
  CHECK(judge(scene, noise()).count(Vote::Unknown) == 81);
}

}  // namespace box_blur_test
