// SPDX-License-Identifier: MIT
// What rendered scenes show, as one number each. Figures of pipelines on these scenes can be compared only
// while these numbers stay. Of geometry and truth, not of colours: their filters come from OpenCV, which
// decides by the processor. The mean colour is compared beside it, and pictures that no filter has touched.
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <sstream>

#include "doctest/doctest.h"
#include "render/room_materials.hpp"
#include "render/sequence_renderer.hpp"
#include "support/digest.hpp"

namespace digest_test {

using namespace dynfilter;
using digest::Digest;

namespace {

std::string digest_of(const render::RenderedFrame& frame) {
  Digest digest;
  for (int y = 0; y < frame.depth.rows; ++y)
    for (int x = 0; x < frame.depth.cols; ++x) {
      digest.add(frame.truth.labels.at<std::uint8_t>(y, x));
      digest.add(frame.truth.dynamic.at<std::uint8_t>(y, x));
      constexpr float kPerMillimetre = 1000;
      digest.add(
          static_cast<std::uint64_t>(std::lround(kPerMillimetre * frame.true_depth_m.at<float>(y, x))));
    }
  return digest.text();
}

std::string digest_of(const cv::Mat& picture) {
  Digest digest;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      for (int c = 0; c < 3; ++c) digest.add(picture.at<cv::Vec3b>(y, x)[c]);
  return digest.text();
}

}  // namespace

TEST_CASE("digests of painted pictures: every compiler draws the random numbers in the same order") {
  Random tile(5), cover(5);
  CHECK(digest_of(render::picture::ceiling_tile(tile)) == "38b1aa706435721f");
  CHECK(digest_of(render::picture::book_cover(cover)) == "ec6f4ec7f5c0150c");
}

TEST_CASE("digests of rendered scenes") {
  const struct {
    const char* scene;
    std::uint64_t seed;
    int frame;
    const char* digest;
    double mean[3];
  } known[] = {
      {"walking_xyz", 1, 7, "27fe6f963386cbf", {97.10, 101.11, 102.17}},
      {"walking_turn_60", 2, 5, "52834e81afd2dbae", {88.65, 94.70, 100.30}},
      {"moving_box", 3, 20, "ecfc875a05114c80", {90.04, 99.70, 106.56}},
  };
  for (const auto& k : known) {
    CAPTURE(k.scene);
    render::SequenceOptions options;
    options.scene = k.scene;
    options.seed = k.seed;
    const render::RenderedFrame frame = render::SequenceRenderer(options).frame(k.frame);
    CHECK(digest_of(frame) == k.digest);
    const cv::Scalar mean = cv::mean(frame.colour);
    for (int c = 0; c < 3; ++c) CHECK(mean[c] == doctest::Approx(k.mean[c]).epsilon(0.002));
  }
}

}  // namespace digest_test
