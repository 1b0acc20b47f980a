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
  copy_rows(descriptors, rows, [](std::size_t r) { return static_cast<int>(r); });
  return true;
}

DYNFILTER_INLINE void DescriptorWords::assign_rows(const cv::Mat& descriptors,
                                                   const std::vector<std::int32_t>& order) {
  copy_rows(descriptors, order.size(), [&](std::size_t r) { return order[r]; });
}

template <class RowOf>
void DescriptorWords::copy_rows(const cv::Mat& descriptors, std::size_t rows, const RowOf& from) {
  const auto bytes = static_cast<std::size_t>(descriptors.cols);
  stride_ = (bytes + 7) / 8;
  words_.assign(rows * stride_, 0);
  for (std::size_t r = 0; r < rows; ++r) std::memcpy(&words_[r * stride_], descriptors.ptr(from(r)), bytes);
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
  const auto octave = [&](std::int64_t apart) {
    using Limits = std::numeric_limits<std::int32_t>;
    return static_cast<std::int32_t>(
        std::clamp<std::int64_t>(feature.octave + apart, Limits::min(), Limits::max()));
  };
  const std::int32_t lowest = octave(-params_.max_octave_difference),
                     highest = octave(params_.max_octave_difference);
  Window window;
  for (int k = 0; k < kMostLanes; ++k) {
    window.x[k] = centre.x, window.y[k] = centre.y, window.radius2[k] = radius * radius;
    window.lowest[k] = lowest, window.highest[k] = highest;
  }
  grid_.ranges_around(centre, radius, [&](std::size_t begin, std::size_t end) {
    detail::call_widest([&](auto lanes) DYNFILTER_AS_CALLER { compare<lanes()>(i, window, begin, end); });
  });
}

template <int kLanes>
DYNFILTER_AS_CALLER inline void DescriptorMatcher::compare(std::size_t i, const Window& window,
                                                           std::size_t begin, std::size_t end) {
  using detail::load_lane;
  using Floats = detail::Vector<float, kLanes>;
  using Ints = detail::Vector<std::int32_t, kLanes>;
  Floats x0, y0, radius2;
  Ints lowest, highest;
  load_lane(window.x, x0), load_lane(window.y, y0), load_lane(window.radius2, radius2);
  load_lane(window.lowest, lowest), load_lane(window.highest, highest);
  constexpr std::size_t kOrbWords = 4;  // known to the compiler, they are counted without a loop
  const std::size_t words = current_words_.stride();
  const std::uint64_t* own = current_words_.row(i);
  Best forward = forward_[i];
  for (std::size_t first = begin; first < end; first += kLanes) {
    Floats x, y;
    Ints octave;
    load_lane(&x_[first], x), load_lane(&y_[first], y), load_lane(&octave_[first], octave);
    x -= x0, y -= y0;
    const Ints inside = (x * x + y * y <= radius2) & (octave >= lowest) & (octave <= highest);
    unsigned bits = detail::sign_bits(inside);
    if (end - first < kLanes) bits &= (1U << (end - first)) - 1;
    for (; bits != 0; bits &= bits - 1) {
      const std::size_t c = first + static_cast<std::size_t>(__builtin_ctz(bits));
      const int d = words == kOrbWords ? detail::hamming(own, reference_words_.row(c), kOrbWords)
                                       : detail::hamming(own, reference_words_.row(c), words);
      if (d > farthest_) continue;
      forward.offer(d, static_cast<std::int32_t>(c));
      backward_[c].offer(d, static_cast<std::int32_t>(i));
    }
  }
  forward_[i] = forward;
}

inline bool DescriptorMatcher::accepted(std::size_t i) const {
  const Best& best = forward_[i];
  if (best.index < 0 || best.distance > params_.max_distance_bits) return false;
  if (best.second != Best::kNone && !(best.distance < params_.max_ratio * best.second)) return false;
  const Best& back = backward_[static_cast<std::size_t>(best.index)];
  return back.index == static_cast<std::int32_t>(i) && back.distance < back.second;
}

}  // namespace dynfilter
