// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/descriptor_match.hpp>

#include <cmath>
#include <cstring>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/parameters.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

namespace detail {

DYNFILTER_INLINE bool DescriptorWords::assign(const cv::Mat& descriptors, std::size_t rows) {
  if (descriptors.empty() || descriptors.type() != CV_8UC1 ||
      static_cast<std::size_t>(descriptors.rows) != rows)
    return false;
  const auto bytes = static_cast<std::size_t>(descriptors.cols);
  stride_ = (bytes + 7) / 8;
  words_.assign(rows * stride_, 0);
  for (std::size_t r = 0; r < rows; ++r)
    std::memcpy(&words_[r * stride_], descriptors.ptr(static_cast<int>(r)), bytes);
  return true;
}

DYNFILTER_INLINE int hamming_256(const std::uint64_t* a, const std::uint64_t* b) {
  constexpr std::uint64_t k5 = 0x5555555555555555U, k3 = 0x3333333333333333U, kF = 0x0F0F0F0F0F0F0F0FU;
  std::uint64_t bytes = 0;
  for (int pair = 0; pair < 4; pair += 2) {
    std::uint64_t x = a[pair] ^ b[pair], y = a[pair + 1] ^ b[pair + 1];
    x -= (x >> 1U) & k5;
    y -= (y >> 1U) & k5;
    x = (x & k3) + ((x >> 2U) & k3) + (y & k3) + ((y >> 2U) & k3);  // nibbles of at most 8
    bytes += (x & kF) + ((x >> 4U) & kF);                           // bytes of at most 32
  }
  // The sum of bytes up to 32 may reach 256, which overflows a byte. Sums use 16 bits.
  bytes = (bytes & 0x00FF00FF00FF00FFU) + ((bytes >> 8U) & 0x00FF00FF00FF00FFU);
  return static_cast<int>((bytes * 0x0001000100010001U) >> 48U);
}

DYNFILTER_INLINE int hamming_64(std::uint64_t x) {
  x -= (x >> 1U) & 0x5555555555555555U;
  x = (x & 0x3333333333333333U) + ((x >> 2U) & 0x3333333333333333U);
  x = (x + (x >> 4U)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<int>((x * 0x0101010101010101U) >> 56U);
}

}  // namespace detail

DYNFILTER_INLINE DescriptorMatcher::DescriptorMatcher(const DescriptorMatchParams& params) : params_(params) {
  check_parameters(params_, "descriptor_match");
}

DYNFILTER_INLINE void DescriptorMatcher::match(const DescribedFeatures& current,
                                               const DescribedFeatures& reference,
                                               Span<const cv::Point2f> expected_px, Correspondences& out) {
  const std::size_t n = current.keypoints.size();
  out.reset(n);
  if (!current_words_.assign(current.descriptors, n) ||
      !reference_words_.assign(reference.descriptors, reference.keypoints.size()) ||
      current.descriptors.cols != reference.descriptors.cols)
    return;
  grid_.build(reference.keypoints, static_cast<float>(params_.search_radius_px) / 2);
  if (grid_.empty()) return;
  if (expected_px.size() != n) expected_px = {};
  forward_.assign(n, Best());
  backward_.assign(reference.keypoints.size(), Best());
  for (std::size_t i = 0; i < n; ++i) search(i, current.keypoints[i], expected_px, reference.keypoints);
  for (std::size_t i = 0; i < n; ++i)
    if (accepted(i))
      out.set(i, reference.keypoints[static_cast<std::size_t>(forward_[i].index)].pt, forward_[i].index);
}

inline void DescriptorMatcher::Best::offer(int d, std::int32_t i) {
  if (d < distance) {
    second = distance;
    distance = d;
    index = i;
  } else if (d < second) {
    second = d;
  }
}

inline void DescriptorMatcher::search(std::size_t i, const cv::KeyPoint& feature,
                                      Span<const cv::Point2f> expected_px,
                                      Span<const cv::KeyPoint> reference) {
  const bool expected = !expected_px.empty() && detail::finite(expected_px[i]);
  const cv::Point2f centre = expected ? expected_px[i] : feature.pt;
  if (!PointGrid::usable(centre)) return;
  const auto radius = static_cast<float>(params_.search_radius_px);
  const std::uint64_t* words = current_words_.row(i);
  grid_.around(centre, radius, [&](std::int32_t j) {
    const cv::KeyPoint& candidate = reference[static_cast<std::size_t>(j)];
    const float dx = candidate.pt.x - centre.x, dy = candidate.pt.y - centre.y;
    if (dx * dx + dy * dy > radius * radius) return;
    if (std::abs(std::int64_t{candidate.octave} - feature.octave) > params_.max_octave_difference) return;
    const int d =
        detail::hamming(words, reference_words_.row(static_cast<std::size_t>(j)), current_words_.stride());
    forward_[i].offer(d, j);
    backward_[static_cast<std::size_t>(j)].offer(d, static_cast<std::int32_t>(i));
  });
}

inline bool DescriptorMatcher::accepted(std::size_t i) const {
  const Best& best = forward_[i];
  if (best.index < 0 || best.distance > params_.max_distance_bits) return false;
  if (best.second != Best::kNone && !(best.distance < params_.max_ratio * best.second)) return false;
  if (!params_.mutual) return true;
  const Best& back = backward_[static_cast<std::size_t>(best.index)];
  return back.index == static_cast<std::int32_t>(i) && back.distance < back.second;
}

}  // namespace dynfilter
