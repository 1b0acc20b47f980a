// SPDX-License-Identifier: MIT
#include <cstdint>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/filters/descriptor_distance.hpp>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "filters/matched_frames.hpp"

namespace descriptor_distance_test {

using namespace dynfilter;
using matched_frames::MatchedFrames;
using matched_frames::votes_of;

TEST_CASE("descriptor_distance: alike is a candidate, unlike is none") {
  MatchedFrames frames;
  for (int k = 0; k < 4; ++k)
    frames.add({10.0F * static_cast<float>(k), 5}, {10.0F * static_cast<float>(k), 6});
  // The last byte is the same everywhere: descriptors that are all zero count as none.
  frames.then_descriptors = cv::Mat::zeros(4, 32, CV_8UC1);
  frames.then_descriptors.col(31) = 1;
  frames.now_descriptors = frames.then_descriptors.clone();
  for (int b = 0; b < 6; ++b) frames.now_descriptors.at<std::uint8_t>(1, b) = 0xFF;  // 48 bits
  for (int b = 0; b < 6; ++b) frames.now_descriptors.at<std::uint8_t>(2, b) = 0xFF;
  frames.now_descriptors.at<std::uint8_t>(2, 6) = 0x07;  // 51 bits
  frames.index[3] = -1;
  DescriptorDistanceFilter filter;
  const Votes votes = votes_of(filter, frames);
  CHECK(votes[0] == Vote::Dynamic);
  CHECK(votes[1] == Vote::Dynamic);
  CHECK(votes[2] == Vote::Static);
  CHECK(votes[3] == Vote::Unknown);
  CHECK(votes.suspicion(0) > votes.suspicion(1));
}

TEST_CASE("descriptor_distance: rows that do not fit, another length, none: unknown") {
  MatchedFrames frames;
  for (int k = 0; k < 4; ++k)
    frames.add({10.0F * static_cast<float>(k), 5}, {10.0F * static_cast<float>(k), 6});
  DescriptorDistanceFilter filter;
  const auto unknown = [&] { return votes_of(filter, frames).count(Vote::Unknown) == 4; };
  CHECK(unknown());
  frames.now_descriptors = cv::Mat::zeros(4, 32, CV_8UC1);
  CHECK(unknown());
  frames.then_descriptors = cv::Mat::zeros(4, 64, CV_8UC1);
  CHECK(unknown());
  frames.then_descriptors = cv::Mat::zeros(3, 32, CV_8UC1);
  CHECK(unknown());
  frames.then_descriptors = cv::Mat::zeros(4, 32, CV_32FC1);
  CHECK(unknown());
}

}  // namespace descriptor_distance_test
