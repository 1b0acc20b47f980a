// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/descriptor_match.hpp>

#include <algorithm>
#include <cstring>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/simd.hpp>
#include <limits>
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
  farthest_ = 1 + static_cast<int>(std::min(kMostBits, params_.max_distance_bits / params_.max_ratio));
  if (expected_px.size() != n) expected_px = {};
  forward_.assign(n, Best());
  backward_.assign(grid_.entries().size(), Best());
  for (std::size_t i = 0; i < n; ++i) {
    const bool expected = !expected_px.empty() && detail::finite(expected_px[i]);
    search(i, current.keypoints[i], expected ? expected_px[i] : current.keypoints[i].pt);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!accepted(i)) continue;
    const auto found = static_cast<std::size_t>(forward_[i].index);
    out.set(i, {x_[found], y_[found]}, grid_.entries()[found]);
  }
}

inline void DescriptorMatcher::lay_out(const DescribedFeatures& reference) {
  const std::vector<std::int32_t>& entries = grid_.entries();
  x_.resize(entries.size() + kMostLanes), y_.resize(x_.size()), octave_.resize(x_.size());
  for (std::size_t c = 0; c < entries.size(); ++c) {
    const cv::KeyPoint& keypoint = reference.keypoints[static_cast<std::size_t>(entries[c])];
    x_[c] = keypoint.pt.x, y_[c] = keypoint.pt.y, octave_[c] = keypoint.octave;
  }
  reference_words_.assign_rows(reference.descriptors, entries);
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
  const Window window = this->window(feature.octave, centre, radius);
  grid_.ranges_around(centre, radius, [&](std::size_t begin, std::size_t end) {
    detail::call_widest([&](auto lanes) DYNFILTER_AS_CALLER { compare<lanes()>(i, window, begin, end); });
  });
}

inline DescriptorMatcher::Window DescriptorMatcher::window(int octave, const cv::Point2f& centre,
                                                           float radius_px) const {
  using Octave = std::numeric_limits<std::int32_t>;
  const auto limit = [](std::int64_t at) {
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(at, Octave::min(), Octave::max()));
  };
  const std::int64_t apart = params_.max_octave_difference;
  Window window;
  std::fill_n(window.x, kMostLanes, centre.x), std::fill_n(window.y, kMostLanes, centre.y);
  std::fill_n(window.radius2, kMostLanes, radius_px * radius_px);
  std::fill_n(window.lowest, kMostLanes, limit(octave - apart));
  std::fill_n(window.highest, kMostLanes, limit(octave + apart));
  return window;
}

template <int kLanes>
DYNFILTER_AS_CALLER inline void DescriptorMatcher::compare(std::size_t i, const Window& window,
                                                           std::size_t begin, std::size_t end) {
  using Floats = detail::Vector<float, kLanes>;
  using Ints = detail::Vector<std::int32_t, kLanes>;
  Floats x0, y0, radius2;
  Ints lowest, highest;
  detail::load_lane(window.x, x0), detail::load_lane(window.y, y0);
  detail::load_lane(window.radius2, radius2);
  detail::load_lane(window.lowest, lowest), detail::load_lane(window.highest, highest);
  Best forward = forward_[i];
  for (std::size_t first = begin; first < end; first += kLanes) {
    Floats x, y;
    Ints octave;
    detail::load_lane(&x_[first], x), detail::load_lane(&y_[first], y);
    detail::load_lane(&octave_[first], octave);
    x -= x0, y -= y0;
    const Ints inside = (x * x + y * y <= radius2) & (octave >= lowest) & (octave <= highest);
    unsigned bits = detail::sign_bits(inside);
    if (end - first < kLanes) bits &= (1U << (end - first)) - 1;
    for (; bits != 0; bits &= bits - 1) {
      const std::size_t c = first + static_cast<std::size_t>(__builtin_ctz(bits));
      const int d = distance<kLanes == kMostLanes>(i, c);
      if (d > farthest_) continue;
      forward.offer(d, static_cast<std::int32_t>(c));
      backward_[c].offer(d, static_cast<std::int32_t>(i));
    }
  }
  forward_[i] = forward;
}

/// A processor with AVX2 counts bits. Four words are 256 bits, as of ORB.
template <bool kCounts>
DYNFILTER_AS_CALLER inline int DescriptorMatcher::distance(std::size_t i, std::size_t c) const {
  const std::uint64_t *a = current_words_.row(i), *b = reference_words_.row(c);
  if (kCounts && current_words_.stride() == 4)
    return __builtin_popcountll(a[0] ^ b[0]) + __builtin_popcountll(a[1] ^ b[1]) +
           __builtin_popcountll(a[2] ^ b[2]) + __builtin_popcountll(a[3] ^ b[3]);
  return detail::hamming(a, b, current_words_.stride());
}

inline bool DescriptorMatcher::accepted(std::size_t i) const {
  const Best& best = forward_[i];
  if (best.index < 0 || best.distance > params_.max_distance_bits) return false;
  if (best.second != Best::kNone && !(best.distance < params_.max_ratio * best.second)) return false;
  const Best& back = backward_[static_cast<std::size_t>(best.index)];
  return back.index == static_cast<std::int32_t>(i) && back.distance < back.second;
}

}  // namespace dynfilter
