// SPDX-License-Identifier: MIT
#include <dynfilter/correspondence/correspondences.hpp>
#include <limits>

#include "doctest/doctest.h"

namespace host_match_test {

using namespace dynfilter;

TEST_CASE("The host's matches are taken with their bounds checked") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<cv::KeyPoint> reference{{10, 20, 1}, {nan, 5, 1}, {30, 40, 1}};
  const std::vector<std::int32_t> index{2, -1, 3, 0, 1, std::numeric_limits<std::int32_t>::max(), -7, 2};
  const HostMatches matches{4, index};
  Correspondences out;
  CHECK(correspondences_from_host(matches, reference, index.size(), out) == 3);
  CHECK(out.found == std::vector<std::uint8_t>{1, 0, 0, 1, 0, 0, 0, 1});
  CHECK(out.reference_index == std::vector<std::int32_t>{2, -1, -1, 0, -1, -1, -1, 2});
  CHECK(out.reference_px[0] == cv::Point2f(30, 40));
  CHECK(out.reference_px[3] == cv::Point2f(10, 20));
  CHECK(std::isnan(out.reference_px[1].x));
  CHECK(out.count() == 3);
}

TEST_CASE("Matches of another length, or to a frame without features, find nothing") {
  const std::vector<cv::KeyPoint> reference{{10, 20, 1}};
  const std::vector<std::int32_t> index{0, 0};
  Correspondences out;
  correspondences_from_host({1, index}, reference, 3, out);
  CHECK(out.size() == 3);
  CHECK(out.count() == 0);
  CHECK(correspondences_from_host({1, index}, {}, 2, out) == 2);
  CHECK(out.count() == 0);
  correspondences_from_host({}, reference, 0, out);
  CHECK(out.size() == 0);
}

}  // namespace host_match_test
