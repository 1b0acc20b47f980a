// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

struct DescriptorMatchParams {
  double search_radius_px = 50;
  int max_octave_difference = 1;
  int max_distance_bits = 64;
  double max_ratio = 0.9;
  bool mutual = true;

  static const FieldTable<DescriptorMatchParams>& fields() {
    using P = DescriptorMatchParams;
    static const FieldTable<P> table{
        real("search_radius_px", &P::search_radius_px, "px", {0.5, 10000},
             "how far from its expected position a feature is searched"),
        integer("max_octave_difference", &P::max_octave_difference, "", {0, 100}, "between the two features"),
        integer("max_distance_bits", &P::max_distance_bits, "bits", {0, 65536}, "Hamming distance"),
        real("max_ratio", &P::max_ratio, "", {0, 1}, "best must be below this share of the second best"),
        flag("mutual", &P::mutual, "the best of both sides only"),
    };
    return table;
  }
};

namespace detail {

/// Binary descriptors as whole 64-bit words, padded with zeros.
class DescriptorWords {
 public:
  /// False when `descriptors` is not CV_8UC1 with `rows` rows.
  bool assign(const cv::Mat& descriptors, std::size_t rows) {
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
  const std::uint64_t* row(std::size_t i) const { return &words_[i * stride_]; }
  std::size_t stride() const { return stride_; }

 private:
  std::vector<std::uint64_t> words_;
  std::size_t stride_ = 0;
};

/// Counts the bits of four words at once: no popcnt instruction is assumed (no -march=native).
inline int hamming_256(const std::uint64_t* a, const std::uint64_t* b) {
  constexpr std::uint64_t k5 = 0x5555555555555555U, k3 = 0x3333333333333333U, kF = 0x0F0F0F0F0F0F0F0FU;
  std::uint64_t bytes = 0;
  for (int pair = 0; pair < 4; pair += 2) {
    std::uint64_t x = a[pair] ^ b[pair], y = a[pair + 1] ^ b[pair + 1];
    x -= (x >> 1U) & k5;
    y -= (y >> 1U) & k5;
    x = (x & k3) + ((x >> 2U) & k3) + (y & k3) + ((y >> 2U) & k3);  // nibbles of at most 8
    bytes += (x & kF) + ((x >> 4U) & kF);                           // bytes of at most 32
  }
  // Bytes hold up to 32: their sum may reach 256 and would overflow one byte, so 16-bit sums.
  bytes = (bytes & 0x00FF00FF00FF00FFU) + ((bytes >> 8U) & 0x00FF00FF00FF00FFU);
  return static_cast<int>((bytes * 0x0001000100010001U) >> 48U);
}

inline int hamming_64(std::uint64_t x) {
  x -= (x >> 1U) & 0x5555555555555555U;
  x = (x & 0x3333333333333333U) + ((x >> 2U) & 0x3333333333333333U);
  x = (x + (x >> 4U)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<int>((x * 0x0101010101010101U) >> 56U);
}

inline int hamming(const std::uint64_t* a, const std::uint64_t* b, std::size_t words) {
  int bits = 0;
  std::size_t w = 0;
  for (; w + 4 <= words; w += 4) bits += hamming_256(a + w, b + w);
  for (; w < words; ++w) bits += hamming_64(a[w] ^ b[w]);
  return bits;
}

/// Keypoints sorted into square cells: finds those around a point without looking at all.
class KeypointGrid {
 public:
  void build(Span<const cv::KeyPoint> keypoints, float cell_px) {
    min_ = {std::numeric_limits<float>::max(), std::numeric_limits<float>::max()};
    cv::Point2f max(std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest());
    for (const cv::KeyPoint& k : keypoints) {
      if (!usable(k.pt)) continue;
      min_ = {std::min(min_.x, k.pt.x), std::min(min_.y, k.pt.y)};
      max = {std::max(max.x, k.pt.x), std::max(max.y, k.pt.y)};
    }
    columns_ = rows_ = 0;
    entries_.clear();
    if (max.x < min_.x) return;
    cell_px_ = std::max({cell_px, 1.0F, (max.x - min_.x) / kMaxCells, (max.y - min_.y) / kMaxCells});
    columns_ = static_cast<int>((max.x - min_.x) / cell_px_) + 1;
    rows_ = static_cast<int>((max.y - min_.y) / cell_px_) + 1;
    fill(keypoints);
  }

  /// Calls f(index) for every keypoint in the cells that a circle touches, and some outside it.
  template <class F>
  void around(const cv::Point2f& centre, float radius_px, const F& f) const {
    const int x0 = cell(centre.x - radius_px - min_.x, columns_),
              y0 = cell(centre.y - radius_px - min_.y, rows_);
    const int x1 = cell(centre.x + radius_px - min_.x, columns_),
              y1 = cell(centre.y + radius_px - min_.y, rows_);
    for (int y = y0; y <= y1; ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * columns_;
      for (std::size_t e = begin_[row + x0]; e < begin_[row + x1 + 1]; ++e) f(entries_[e]);
    }
  }
  bool empty() const { return entries_.empty(); }

  static bool usable(const cv::Point2f& p) { return std::abs(p.x) < 1e6F && std::abs(p.y) < 1e6F; }

 private:
  static constexpr float kMaxCells = 256;

  int cell(float offset_px, int count) const {
    return static_cast<int>(std::clamp(offset_px / cell_px_, 0.0F, static_cast<float>(count - 1)));
  }
  std::size_t cell_of(const cv::Point2f& p) const {
    return static_cast<std::size_t>(cell(p.y - min_.y, rows_)) * columns_ + cell(p.x - min_.x, columns_);
  }
  void fill(Span<const cv::KeyPoint> keypoints) {
    begin_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
    for (const cv::KeyPoint& k : keypoints)
      if (usable(k.pt)) ++begin_[cell_of(k.pt) + 1];
    for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    entries_.resize(begin_.back());
    next_.assign(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < keypoints.size(); ++i)
      if (usable(keypoints[i].pt)) entries_[next_[cell_of(keypoints[i].pt)]++] = static_cast<std::int32_t>(i);
  }

  cv::Point2f min_;
  float cell_px_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<std::size_t> begin_, next_;
  std::vector<std::int32_t> entries_;
};

}  // namespace detail

/// The features of one frame, for matching.
struct DescribedFeatures {
  Span<const cv::KeyPoint> keypoints;  ///< distorted pixels, with octave
  cv::Mat descriptors;                 ///< CV_8UC1, one row per keypoint, any length
};

/// Windowed matching of binary descriptors, for hosts that bring them: no flow and no image needed. A match
/// is the only best candidate within the search radius; ties are no match, so the order of features does not
/// matter. Buffers are kept from call to call.
class DescriptorMatcher {
 public:
  explicit DescriptorMatcher(const DescriptorMatchParams& params = DescriptorMatchParams())
      : params_(params) {
    check_parameters(params_, "descriptor_match");
  }
  const DescriptorMatchParams& params() const { return params_; }

  /// `expected_px`: where each current feature is expected in the reference frame, NaN for no idea; empty:
  /// where it is now. Descriptors that are missing or of different length find nothing.
  void match(const DescribedFeatures& current, const DescribedFeatures& reference,
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

 private:
  struct Best {
    static constexpr int kNone = std::numeric_limits<int>::max();
    int distance = kNone, second = kNone;
    std::int32_t index = -1;

    void offer(int d, std::int32_t i) {
      if (d < distance) {
        second = distance;
        distance = d;
        index = i;
      } else if (d < second) {
        second = d;
      }
    }
  };

  void search(std::size_t i, const cv::KeyPoint& feature, Span<const cv::Point2f> expected_px,
              Span<const cv::KeyPoint> reference) {
    const bool expected = !expected_px.empty() && detail::finite(expected_px[i]);
    const cv::Point2f centre = expected ? expected_px[i] : feature.pt;
    if (!detail::KeypointGrid::usable(centre)) return;
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

  bool accepted(std::size_t i) const {
    const Best& best = forward_[i];
    if (best.index < 0 || best.distance > params_.max_distance_bits) return false;
    if (best.second != Best::kNone && !(best.distance < params_.max_ratio * best.second)) return false;
    if (!params_.mutual) return true;
    const Best& back = backward_[static_cast<std::size_t>(best.index)];
    return back.index == static_cast<std::int32_t>(i) && back.distance < back.second;
  }

  DescriptorMatchParams params_;
  detail::DescriptorWords current_words_, reference_words_;
  detail::KeypointGrid grid_;
  std::vector<Best> forward_, backward_;
};

}  // namespace dynfilter
