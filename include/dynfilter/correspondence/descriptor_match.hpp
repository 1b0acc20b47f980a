// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace dynfilter {

namespace detail {

/// Binary descriptors as whole 64-bit words, padded with zeros.
class DescriptorWords {
 public:
  static bool fits(const cv::Mat& descriptors, std::size_t rows);
  /// Returns false if `descriptors` is not CV_8UC1 with `rows` rows.
  bool assign(const cv::Mat& descriptors, std::size_t rows);
  /// Only the rows of `order`, in that order. Requires descriptors that fit.
  void assign_rows(const cv::Mat& descriptors, const std::vector<std::int32_t>& order);
  const std::uint64_t* row(std::size_t i) const { return &words_[i * stride_]; }
  std::size_t stride() const { return stride_; }

 private:
  template <class RowOf>
  void copy_rows(const cv::Mat& descriptors, std::size_t rows, const RowOf& from);

  std::vector<std::uint64_t> words_;
  std::size_t stride_ = 0;
};

DYNFILTER_AS_CALLER inline int hamming(const std::uint64_t* a, const std::uint64_t* b, std::size_t words) {
  int bits = 0;
  for (std::size_t w = 0; w < words; ++w) bits += __builtin_popcountll(a[w] ^ b[w]);
  return bits;
}

}  // namespace detail

/// Features of one frame for matching.
struct DescribedFeatures {
  Span<const cv::KeyPoint> keypoints;  ///< distorted pixels, with octave
  cv::Mat descriptors;                 ///< CV_8UC1, one row per keypoint, any length
};

/// Matches binary descriptors within a search window, without flow or images.
/// A match is the unique best candidate within the search radius.
/// A tie gives no match, so the order of the features does not matter. Buffers are reused from call to call.
class DescriptorMatcher {
 public:
  explicit DescriptorMatcher(const DescriptorMatchParams& params = DescriptorMatchParams());
  const DescriptorMatchParams& params() const { return params_; }

  /// `expected_px` is the expected position of each current feature in the reference frame.
  /// NaN means unknown. If the array is empty, the current positions are expected.
  /// Nothing is found if descriptors are missing or differ in length. A feature with more than
  /// limits::kMaxWindow candidates in the cells around its window has no match.
  void match(const DescribedFeatures& current, const DescribedFeatures& reference,
             Span<const cv::Point2f> expected_px, Correspondences& out);
  /// Features of the last call with too many candidates.
  std::size_t crowded() const { return crowded_; }

 private:
  struct Best {
    static constexpr int kNone = std::numeric_limits<int>::max();
    int distance = kNone, second = kNone;
    std::int32_t index = -1;
    void offer(int d, std::int32_t i);
  };

  static constexpr int kMostLanes = 8;  ///< of a vector
  /// What a candidate must keep to, the same in each lane: place, squared radius and octaves.
  struct Window {
    float x[kMostLanes], y[kMostLanes], radius2[kMostLanes];
    std::int32_t lowest[kMostLanes], highest[kMostLanes];
  };

  void lay_out(const DescribedFeatures& reference);
  void search(std::size_t i, const cv::KeyPoint& feature, const cv::Point2f& centre);
  /// Compares feature i with those of the candidates from `begin` to `end` that are in the window.
  template <int kLanes>
  DYNFILTER_AS_CALLER void compare(std::size_t i, const Window& window, std::size_t begin, std::size_t end);
  bool accepted(std::size_t i) const;

  DescriptorMatchParams params_;
  detail::DescriptorWords current_words_, reference_words_;
  PointGrid grid_;
  // Features of the reference frame, in the order of the grid, so that a search reads memory in order.
  std::vector<float> x_, y_;
  std::vector<std::int32_t> octave_;
  std::size_t crowded_ = 0;
  static constexpr double kMostBits = 1e6;  ///< of a descriptor
  int farthest_ = 0;                        ///< distance: one beyond it changes no match
  std::vector<Best> forward_, backward_;    ///< of the candidates, the second
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/descriptor_match-inl.hpp>
#endif
