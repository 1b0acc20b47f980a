// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/descriptor_match.hpp>

#include <cmath>
#include <cstring>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/limits.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

namespace detail {

DYNFILTER_INLINE bool DescriptorWords::fits(const cv::Mat& descriptors, std::size_t rows) {
  return !descriptors.empty() && descriptors.type() == CV_8UC1 &&
         static_cast<std::size_t>(descriptors.rows) == rows;
}

DYNFILTER_INLINE bool DescriptorWords::assign(const cv::Mat& descriptors, std::size_t rows) {
  if (!fits(descriptors, rows)) return false;
  reserve_rows(descriptors, rows);
  for (std::size_t r = 0; r < rows; ++r) copy_row(descriptors, static_cast<int>(r), r);
  return true;
}

DYNFILTER_INLINE void DescriptorWords::assign_rows(const cv::Mat& descriptors,
                                                   const std::vector<std::int32_t>& order) {
  reserve_rows(descriptors, order.size());
  for (std::size_t r = 0; r < order.size(); ++r) copy_row(descriptors, order[r], r);
}

inline void DescriptorWords::reserve_rows(const cv::Mat& descriptors, std::size_t rows) {
  stride_ = (static_cast<std::size_t>(descriptors.cols) + 7) / 8;
  words_.assign(rows * stride_, 0);
}

inline void DescriptorWords::copy_row(const cv::Mat& descriptors, int from, std::size_t to) {
  std::memcpy(&words_[to * stride_], descriptors.ptr(from), static_cast<std::size_t>(descriptors.cols));
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
  crowded_ = 0;
  if (!detail::DescriptorWords::fits(reference.descriptors, reference.keypoints.size()) ||
      current.descriptors.cols != reference.descriptors.cols ||
      !current_words_.assign(current.descriptors, n))
    return;
  grid_.build(reference.keypoints, static_cast<float>(params_.search_radius_px) / 2);
  if (grid_.empty()) return;
  lay_out(reference);
  if (expected_px.size() != n) expected_px = {};
  forward_.assign(n, Best());
  backward_.assign(candidates_.size(), Best());
  for (std::size_t i = 0; i < n; ++i) {
    const bool expected = !expected_px.empty() && detail::finite(expected_px[i]);
    search(i, current.keypoints[i], expected ? expected_px[i] : current.keypoints[i].pt);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!accepted(i)) continue;
    const Candidate& found = candidates_[static_cast<std::size_t>(forward_[i].index)];
    out.set(i, found.px, found.index);
  }
}

inline void DescriptorMatcher::lay_out(const DescribedFeatures& reference) {
  candidates_.clear();
  for (const std::int32_t j : grid_.entries()) {
    const cv::KeyPoint& keypoint = reference.keypoints[static_cast<std::size_t>(j)];
    candidates_.push_back({keypoint.pt, keypoint.octave, j});
  }
  reference_words_.assign_rows(reference.descriptors, grid_.entries());
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

inline void DescriptorMatcher::search(std::size_t i, const cv::KeyPoint& feature, const cv::Point2f& centre) {
  const auto radius = static_cast<float>(params_.search_radius_px);
  std::size_t candidates = 0;
  grid_.ranges_around(centre, radius, [&](std::size_t begin, std::size_t end) { candidates += end - begin; });
  if (candidates > limits::kMaxWindow) {
    ++crowded_;
    return;
  }
  grid_.ranges_around(centre, radius, [&](std::size_t begin, std::size_t end) {
    const Span<const std::uint32_t> inside = in_window(feature.octave, centre, radius * radius, begin, end);
#ifdef DYNFILTER_AVX2
    if (current_words_.stride() == 4 && uses_avx2()) return compare_by_popcnt(i, inside);
#endif
    for (const std::uint32_t c : inside)
      offer(i, c, detail::hamming(current_words_.row(i), reference_words_.row(c), current_words_.stride()));
  });
}

inline void DescriptorMatcher::offer(std::size_t i, std::uint32_t c, int distance) {
  forward_[i].offer(distance, static_cast<std::int32_t>(c));
  backward_[c].offer(distance, static_cast<std::int32_t>(i));
}

#ifdef DYNFILTER_AVX2
/// A processor with AVX2 has popcnt. Four words are 256 bits, as of ORB.
DYNFILTER_AVX2 inline void DescriptorMatcher::compare_by_popcnt(std::size_t i,
                                                                Span<const std::uint32_t> candidates) {
  const std::uint64_t* a = current_words_.row(i);
  Best forward = forward_[i];
  for (const std::uint32_t c : candidates) {
    const std::uint64_t* b = reference_words_.row(c);
    const int distance = __builtin_popcountll(a[0] ^ b[0]) + __builtin_popcountll(a[1] ^ b[1]) +
                         __builtin_popcountll(a[2] ^ b[2]) + __builtin_popcountll(a[3] ^ b[3]);
    if (distance < forward.second) forward.offer(distance, static_cast<std::int32_t>(c));
    if (distance < backward_[c].second) backward_[c].offer(distance, static_cast<std::int32_t>(i));
  }
  forward_[i] = forward;
}
#endif

inline Span<const std::uint32_t> DescriptorMatcher::in_window(int octave, const cv::Point2f& centre,
                                                              float radius2, std::size_t begin,
                                                              std::size_t end) {
  if (in_window_.size() < end - begin) in_window_.resize(end - begin);
  std::size_t count = 0;
  // Without a branch: whether a candidate is in the window is hard to predict.
  for (std::size_t c = begin; c < end; ++c) {
    const Candidate& candidate = candidates_[c];
    const float dx = candidate.px.x - centre.x, dy = candidate.px.y - centre.y;
    const std::int64_t apart = std::abs(std::int64_t{candidate.octave} - octave);
    in_window_[count] = static_cast<std::uint32_t>(c);
    const int inside = static_cast<int>(dx * dx + dy * dy <= radius2) &
                       static_cast<int>(apart <= params_.max_octave_difference);
    count += static_cast<std::size_t>(inside);
  }
  return {in_window_.data(), count};
}

inline bool DescriptorMatcher::accepted(std::size_t i) const {
  const Best& best = forward_[i];
  if (best.index < 0 || best.distance > params_.max_distance_bits) return false;
  if (best.second != Best::kNone && !(best.distance < params_.max_ratio * best.second)) return false;
  const Best& back = backward_[static_cast<std::size_t>(best.index)];
  return back.index == static_cast<std::int32_t>(i) && back.distance < back.second;
}

}  // namespace dynfilter
