// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <limits>
#include <numeric>
#include <random>

#include "doctest/doctest.h"

namespace descriptor_match_test {

using namespace dynfilter;

namespace {

struct Features {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  DescribedFeatures view() const { return {keypoints, descriptors}; }
};

Features random_features(std::size_t n, int bytes, unsigned seed, float width_px = 640,
                         float height_px = 480) {
  std::mt19937 random(seed);
  const auto unit = [&] { return static_cast<float>(random() >> 8U) / 16777216.0F; };
  Features f;
  f.descriptors.create(static_cast<int>(n), bytes, CV_8UC1);
  for (std::size_t i = 0; i < n; ++i) {
    f.keypoints.emplace_back(cv::Point2f(unit() * width_px, unit() * height_px), 31.0F, -1.0F, 0.0F,
                             static_cast<int>(random() % 4));
    for (int b = 0; b < bytes; ++b)
      f.descriptors.at<unsigned char>(static_cast<int>(i), b) = static_cast<unsigned char>(random() >> 24U);
  }
  return f;
}

// The same features in another order, moved by up to `motion_px`, with `flips` bits changed, at most one
// octave apart.
Features moved(const Features& from, float motion_px, int flips, unsigned seed,
               std::vector<std::int32_t>& origin) {
  std::mt19937 random(seed);
  const auto unit = [&] { return static_cast<float>(random() >> 8U) / 16777216.0F; };
  const auto n = static_cast<int>(from.keypoints.size());
  origin.resize(from.keypoints.size());
  std::iota(origin.begin(), origin.end(), 0);
  for (std::size_t i = origin.size(); i > 1; --i) std::swap(origin[i - 1], origin[random() % i]);
  Features f;
  f.descriptors.create(n, from.descriptors.cols, CV_8UC1);
  for (int i = 0; i < n; ++i) {
    cv::KeyPoint k = from.keypoints[static_cast<std::size_t>(origin[static_cast<std::size_t>(i)])];
    const float length = motion_px * unit(), angle = 6.2831853F * unit();
    k.pt += cv::Point2f(length * std::cos(angle), length * std::sin(angle));
    k.octave += static_cast<int>(random() % 2);
    f.keypoints.push_back(k);
    from.descriptors.row(origin[static_cast<std::size_t>(i)]).copyTo(f.descriptors.row(i));
    for (int flip = 0; flip < flips; ++flip) {
      const unsigned bit = static_cast<unsigned>(random()) % static_cast<unsigned>(8 * from.descriptors.cols);
      f.descriptors.at<unsigned char>(i, static_cast<int>(bit / 8)) ^=
          static_cast<unsigned char>(1U << (bit % 8));
    }
  }
  return f;
}

int bits_between(const cv::Mat& a, int row_a, const cv::Mat& b, int row_b) {
  int bits = 0;
  for (int c = 0; c < a.cols; ++c)
    for (int bit = 0; bit < 8; ++bit)
      bits += ((a.at<unsigned char>(row_a, c) ^ b.at<unsigned char>(row_b, c)) >> bit) & 1;
  return bits;
}

// Reference implementation: every pair, without grid and words.
struct Twin {
  const Features &current, &reference;
  const DescriptorMatchParams& params;
  const std::vector<cv::Point2f>& expected;

  bool candidate(std::size_t i, std::size_t j) const {
    const cv::Point2f centre =
        expected.empty() || std::isnan(expected[i].x) ? current.keypoints[i].pt : expected[i];
    const cv::Point2f d = reference.keypoints[j].pt - centre;
    const auto radius = static_cast<float>(params.search_radius_px);
    return d.x * d.x + d.y * d.y <= radius * radius &&
           std::abs(current.keypoints[i].octave - reference.keypoints[j].octave) <=
               params.max_octave_difference;
  }
  int distance(std::size_t i, std::size_t j) const {
    return bits_between(current.descriptors, static_cast<int>(i), reference.descriptors, static_cast<int>(j));
  }
  std::int32_t match(std::size_t i) const {
    std::vector<std::pair<int, std::int32_t>> found;
    for (std::size_t j = 0; j < reference.keypoints.size(); ++j)
      if (candidate(i, j)) found.emplace_back(distance(i, j), static_cast<std::int32_t>(j));
    std::sort(found.begin(), found.end());
    if (found.empty() || found[0].first > params.max_distance_bits) return -1;
    if (found.size() > 1 && found[0].first >= params.max_ratio * found[1].first) return -1;
    for (std::size_t k = 0; k < current.keypoints.size(); ++k)
      if (k != i && candidate(k, static_cast<std::size_t>(found[0].second)) &&
          distance(k, static_cast<std::size_t>(found[0].second)) <= found[0].first)
        return -1;
    return found[0].second;
  }
};

std::size_t compare_with_twin(const Features& current, const Features& reference,
                              const DescriptorMatchParams& params, const std::vector<cv::Point2f>& expected) {
  DescriptorMatcher matcher(params);
  Correspondences out;
  matcher.match(current.view(), reference.view(), expected, out);
  const Twin twin{current, reference, params, expected};
  for (std::size_t i = 0; i < current.keypoints.size(); ++i) {
    const std::int32_t index = twin.match(i);
    CHECK(out.reference_index[i] == index);
    CHECK((out.found[i] != 0) == (index >= 0));
    if (index >= 0) CHECK(out.reference_px[i] == reference.keypoints[static_cast<std::size_t>(index)].pt);
  }
  return out.count();
}

}  // namespace

TEST_CASE("Matches are those of the brute-force twin") {
  std::vector<std::int32_t> origin;
  for (const int bytes : {1, 8, 32, 61, 64})
    for (unsigned seed = 0; seed < 2; ++seed) {
      const Features reference = random_features(200, bytes, 10 + seed, 300, 200);
      const Features current = moved(reference, 40, bytes / 2, 20 + seed, origin);
      DescriptorMatchParams params;
      for (const double ratio : {1.0, 0.8})
        for (const double radius_px : {15.0, 50.0, 10000.0}) {
          params.max_ratio = ratio;
          params.search_radius_px = radius_px;
          params.max_octave_difference = seed == 0 ? 0 : 1;
          params.max_distance_bits = 2 * bytes;
          compare_with_twin(current, reference, params, {});
        }
    }
}

TEST_CASE("Every feature that moved within the radius is found again") {
  std::vector<std::int32_t> origin;
  const Features reference = random_features(600, 32, 1);
  const Features current = moved(reference, 45, 20, 2, origin);
  DescriptorMatcher matcher;
  Correspondences out;
  matcher.match(current.view(), reference.view(), {}, out);
  CHECK(out.reference_index == origin);
}

TEST_CASE("An expected position moves the window") {
  std::vector<std::int32_t> origin;
  const Features reference = random_features(300, 32, 3);
  Features current = moved(reference, 8, 10, 4, origin);
  std::vector<cv::Point2f> expected;
  for (cv::KeyPoint& k : current.keypoints) {
    expected.push_back(k.pt);
    k.pt += cv::Point2f(120, -80);
  }
  DescriptorMatchParams params;
  params.search_radius_px = 10;
  CHECK(compare_with_twin(current, reference, params, expected) == 300);
  CHECK(compare_with_twin(current, reference, params, {}) < 10);
  // Unknown: searched at its current position.
  expected[7].x = std::numeric_limits<float>::quiet_NaN();
  compare_with_twin(current, reference, params, expected);
}

TEST_CASE("Two that look the same are no match, whatever their order") {
  Features reference = random_features(2, 32, 5, 10, 10), current = random_features(1, 32, 6, 10, 10);
  for (auto* f : {&reference, &current})
    for (cv::KeyPoint& k : f->keypoints) k.octave = 0;
  current.descriptors.row(0).copyTo(reference.descriptors.row(0));
  current.descriptors.row(0).copyTo(reference.descriptors.row(1));
  Correspondences out;
  DescriptorMatchParams params;
  params.max_ratio = 1;
  DescriptorMatcher matcher(params);
  matcher.match(current.view(), reference.view(), {}, out);
  CHECK(out.count() == 0);
  matcher.match(reference.view(), current.view(), {}, out);
  CHECK(out.count() == 0);
}

TEST_CASE("Odd input finds nothing and throws nothing") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<std::int32_t> origin;
  const Features reference = random_features(50, 32, 7);
  Features current = moved(reference, 5, 5, 8, origin);
  DescriptorMatcher matcher;
  Correspondences out;
  const auto count = [&](const DescribedFeatures& a, const DescribedFeatures& b) {
    matcher.match(a, b, {}, out);
    CHECK(out.size() == a.keypoints.size());
    return out.count();
  };
  CHECK(count(current.view(), reference.view()) == 50);
  CHECK(count({}, reference.view()) == 0);
  CHECK(count(current.view(), {}) == 0);
  CHECK(count({current.keypoints, cv::Mat()}, reference.view()) == 0);
  CHECK(count({current.keypoints, current.descriptors.rowRange(0, 49)}, reference.view()) == 0);
  CHECK(count({current.keypoints, current.descriptors.colRange(0, 16)}, reference.view()) == 0);
  cv::Mat floats;
  current.descriptors.convertTo(floats, CV_32F);
  CHECK(count({current.keypoints, floats}, reference.view()) == 0);
  current.keypoints[3].pt.x = nan;
  current.keypoints[4].pt = {1e30F, -1e30F};
  current.keypoints[5].octave = std::numeric_limits<int>::min();
  CHECK(count(current.view(), reference.view()) == 47);
  Features wild = reference;
  wild.keypoints[static_cast<std::size_t>(origin[10])].pt.y = nan;
  // A huge extent: large cells.
  wild.keypoints[static_cast<std::size_t>(origin[11])].pt = {9e5F, -9e5F};
  CHECK(count(current.view(), wild.view()) == 45);
}

TEST_CASE("Counting bits by words is counting bits") {
  std::mt19937_64 random(9);
  std::uint64_t a[9], b[9];
  for (int round = 0; round < 50; ++round) {
    for (int w = 0; w < 9; ++w) {
      a[w] = random();
      b[w] = round == 0 ? ~a[w] : random();
    }
    int bits = 0;
    for (std::size_t words = 0; words <= 9; ++words) {
      CHECK(detail::hamming(a, b, words) == bits);
      if (words == 9) break;
      for (std::uint64_t x = a[words] ^ b[words]; x != 0; x &= x - 1) ++bits;
    }
  }
}

TEST_CASE("a feature with too many candidates has no match, and others keep theirs") {
  std::vector<cv::KeyPoint> keypoints{cv::KeyPoint(900, 900, 1)};
  for (std::size_t i = 0; i <= dynfilter::limits::kMaxWindow; ++i)
    keypoints.emplace_back(static_cast<float>(i % 20), static_cast<float>(i / 20 % 20), 1.0F);
  cv::Mat descriptors(static_cast<int>(keypoints.size()), 32, CV_8UC1);
  cv::randu(descriptors, 0, 255);
  dynfilter::DescriptorMatcher matcher;
  dynfilter::Correspondences out;
  matcher.match({keypoints, descriptors}, {keypoints, descriptors}, {}, out);
  CHECK(out.count() == 1);
  CHECK(out.reference_index[0] == 0);
  CHECK(matcher.crowded() == keypoints.size() - 1);
  keypoints.pop_back();
  const cv::Mat fewer = descriptors.rowRange(0, descriptors.rows - 1);
  matcher.match({keypoints, fewer}, {keypoints, fewer}, {}, out);
  CHECK(matcher.crowded() == 0);
  CHECK(out.count() > keypoints.size() / 2);
}

}  // namespace descriptor_match_test
