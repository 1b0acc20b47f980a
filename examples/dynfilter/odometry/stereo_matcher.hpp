// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "descriptor.hpp"
#include "frame_features.hpp"
#include "options.hpp"
#include "orb_extractor.hpp"

namespace dynfilter::odometry {

/// Finds the features of a left image in the rectified right image.
/// Candidates are ORB features on the same row, the best descriptor wins. Then a patch is shifted along the
/// row for the smallest sum of absolute differences, and a parabola gives the fraction of a pixel.
/// Matches whose patch differs much more than the median are dropped.
/// Cost: that of a second extraction, and about 2 ms for 1000 features.
class StereoMatcher {
 public:
  StereoMatcher(const ExtractorOptions& extractor, const StereoOptions& options)
      : options_(options), scale_factor_(extractor.scale_factor), extractor_(extractor) {}

  /// Sets `right_u_px` (NaN: no match) and `depth_m` (NaN: none or beyond the least disparity).
  /// `left` is the extractor that has just found the features.
  void match(const OrbExtractor& left, const cv::Mat& right, double fx_px, double baseline_fx_px_m,
             FrameFeatures& features) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    features.right_u_px.assign(features.size(), kNone);
    features.depth_m.assign(features.size(), kNone);
    if (right.empty()) return;
    extractor_.extract(right, keypoints_, descriptors_);
    list_rows(right.rows);
    matches_.clear();
    const double largest_px = fx_px / options_.nearest_baselines;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const std::int32_t candidate = best_on_row(features, i, largest_px);
      if (candidate < 0) continue;
      if (auto match = refined(left, features.keypoints[i], keypoints_[candidate])) {
        match->feature = i;
        matches_.push_back(*match);
      }
    }
    drop_poor_patches();
    for (const Match& match : matches_) {
      const double disparity_px = features.keypoints[match.feature].pt.x - match.right_u_px;
      if (disparity_px < -options_.tolerance_px || disparity_px > largest_px || match.right_u_px < 0)
        continue;
      features.right_u_px[match.feature] = static_cast<float>(match.right_u_px);
      if (disparity_px >= options_.least_disparity_px)
        features.depth_m[match.feature] = static_cast<float>(baseline_fx_px_m / disparity_px);
    }
  }

 private:
  static constexpr int kHalfPatch = 5, kReach = 5;  // px of the feature's pyramid level

  struct Match {
    std::size_t feature;
    double right_u_px;
    int difference;
  };

  double scale_of(int octave) const { return std::pow(scale_factor_, octave); }

  /// For each row the right features whose position may be off it by their own uncertainty.
  void list_rows(int rows) {
    rows_.resize(static_cast<std::size_t>(rows));
    for (auto& row : rows_) row.clear();
    for (std::size_t i = 0; i < keypoints_.size(); ++i) {
      const double reach = options_.row_tolerance_px * scale_of(keypoints_[i].octave);
      const int first = std::max(0, static_cast<int>(std::ceil(keypoints_[i].pt.y - reach))),
                last = std::min(rows - 1, static_cast<int>(std::floor(keypoints_[i].pt.y + reach)));
      for (int r = first; r <= last; ++r)
        rows_[static_cast<std::size_t>(r)].push_back(static_cast<std::int32_t>(i));
    }
  }

  std::int32_t best_on_row(const FrameFeatures& features, std::size_t i, double largest_px) const {
    const cv::KeyPoint& keypoint = features.keypoints[i];
    const int row = cvRound(keypoint.pt.y);
    if (row < 0 || row >= static_cast<int>(rows_.size())) return -1;
    std::int32_t best = -1;
    int least = options_.max_distance + 1;
    for (const std::int32_t k : rows_[static_cast<std::size_t>(row)]) {
      const cv::KeyPoint& other = keypoints_[k];
      if (std::abs(other.octave - keypoint.octave) > 1) continue;
      const float disparity_px = keypoint.pt.x - other.pt.x;
      if (disparity_px < -options_.tolerance_px || disparity_px > largest_px) continue;
      const int distance = hamming(features.descriptors[i], descriptors_[k]);
      if (distance >= least) continue;
      least = distance;
      best = k;
    }
    return best;
  }

  /// The place of the left patch in the right image, in the pyramid level of the left feature.
  std::optional<Match> refined(const OrbExtractor& left, const cv::KeyPoint& from,
                               const cv::KeyPoint& to) const {
    const double scale = scale_of(from.octave);
    const cv::Mat &left_level = left.level(from.octave), &right_level = extractor_.level(from.octave);
    const int u = cvRound(from.pt.x / scale), v = cvRound(from.pt.y / scale), at = cvRound(to.pt.x / scale);
    const int margin = kHalfPatch + kReach;
    if (u < kHalfPatch || v < kHalfPatch || at < margin || u >= left_level.cols - kHalfPatch ||
        v >= left_level.rows - kHalfPatch || at >= right_level.cols - margin)
      return std::nullopt;
    int difference[2 * kReach + 1];
    for (int shift = -kReach; shift <= kReach; ++shift)
      difference[shift + kReach] = patch_difference(left_level, u, right_level, at + shift, v);
    const auto least = std::min_element(std::begin(difference), std::end(difference));
    const auto k = static_cast<int>(least - difference);
    if (k == 0 || k == 2 * kReach) return std::nullopt;
    const double before = difference[k - 1], here = *least, after = difference[k + 1];
    const double bend = before + after - 2 * here;
    const double fraction = bend > 0 ? 0.5 * (before - after) / bend : 0;
    // The left feature is not on a whole pixel of its level; its patch is compared at the nearest one.
    const double disparity = u - (at + k - kReach + fraction);
    return Match{0, from.pt.x - scale * disparity, *least};
  }

  /// Sum of absolute differences of two patches, each relative to its centre.
  static int patch_difference(const cv::Mat& left, int u, const cv::Mat& right, int right_u, int v) {
    const int left_centre = left.at<std::uint8_t>(v, u), right_centre = right.at<std::uint8_t>(v, right_u);
    int sum = 0;
    for (int y = -kHalfPatch; y <= kHalfPatch; ++y) {
      const std::uint8_t *a = left.ptr<std::uint8_t>(v + y) + u,
                         *b = right.ptr<std::uint8_t>(v + y) + right_u;
      for (int x = -kHalfPatch; x <= kHalfPatch; ++x)
        sum += std::abs((a[x] - left_centre) - (b[x] - right_centre));
    }
    return sum;
  }

  void drop_poor_patches() {
    if (matches_.empty()) return;
    std::vector<int> differences;
    for (const Match& match : matches_) differences.push_back(match.difference);
    const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    const double limit = options_.max_patch_ratio * *middle;
    matches_.erase(std::remove_if(matches_.begin(), matches_.end(),
                                  [limit](const Match& match) { return match.difference > limit; }),
                   matches_.end());
  }

  StereoOptions options_;
  double scale_factor_;
  OrbExtractor extractor_;  ///< of the right image
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<Descriptor> descriptors_;
  std::vector<std::vector<std::int32_t>> rows_;
  std::vector<Match> matches_;
};

}  // namespace dynfilter::odometry
