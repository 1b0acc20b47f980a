// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <numeric>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// Restores rejected features, least suspicious first, until the floor is satisfied.
class Floor {
 public:
  explicit Floor(const FloorParams& params = FloorParams()) : params_(params) {}

  /// `host_min_features`: the tracker needs at least so many, whatever the parameters say.
  void apply(const FrameView& frame, int host_min_features, Verdict& verdict);

 private:
  /// Sorts rejected features by suspicion, then by position, so that the result does not depend on the order
  /// of the features.
  void rank(const FrameView& frame, const Verdict& verdict);

  /// All NaN positions count as one position, because NaN cannot be ordered.
  static cv::Point2f place_of(const FrameView& frame, std::size_t i) {
    const cv::Point2f& pt = frame.keypoints[i].pt;
    return std::isnan(pt.x) || std::isnan(pt.y) ? cv::Point2f() : pt;
  }

  void raise_count(const FrameView& frame, int host_min_features, Verdict& verdict);
  void raise_coverage(const FrameView& frame, Verdict& verdict);

  /// The grid covers the image if its size is known, else the extent of the features.
  void lay_grid(const FrameView& frame);
  std::size_t cell_of(const FrameView& frame, std::size_t i) const {
    const cv::Point2f& pt = frame.keypoints[i].pt;
    return static_cast<std::size_t>(grid_.of(pt.x, pt.y));
  }
  static void restore(Verdict& verdict, std::size_t i) {
    verdict.decision[i] = Vote::Unknown;
    verdict.restored[i] = 1;
    ++verdict.report.restored;
  }

  FloorParams params_;
  std::vector<std::size_t> ranked_;
  std::vector<std::uint8_t> occupied_, covered_;
  ImageCells<float> grid_;
};

inline void Floor::apply(const FrameView& frame, int host_min_features, Verdict& verdict) {
  ranked_.clear();
  const std::size_t restored_before = verdict.report.restored;
  raise_count(frame, host_min_features, verdict);
  raise_coverage(frame, verdict);
  const std::size_t restored = verdict.report.restored - restored_before;
  if (restored > 0)
    verdict.report.notes.push_back("floor: " + std::to_string(restored) + " features restored");
}

inline void Floor::rank(const FrameView& frame, const Verdict& verdict) {
  for (std::size_t i = 0; i < verdict.size(); ++i)
    if (!verdict.keep(i)) ranked_.push_back(i);
  std::sort(ranked_.begin(), ranked_.end(), [&](std::size_t a, std::size_t b) {
    if (verdict.suspicion[a] != verdict.suspicion[b]) return verdict.suspicion[a] < verdict.suspicion[b];
    const cv::Point2f pa = place_of(frame, a), pb = place_of(frame, b);
    if (pa.y != pb.y) return pa.y < pb.y;
    if (pa.x != pb.x) return pa.x < pb.x;
    return a < b;
  });
}

inline void Floor::raise_count(const FrameView& frame, int host_min_features, Verdict& verdict) {
  const auto by_share =
      static_cast<std::size_t>(std::ceil(params_.min_share * static_cast<double>(verdict.size())));
  const std::size_t own = std::max(static_cast<std::size_t>(params_.min_features), by_share);
  const std::size_t wanted = std::max(own, static_cast<std::size_t>(std::max(host_min_features, 0)));
  std::size_t kept = verdict.kept();
  if (kept >= wanted) return;
  const bool all = params_.restore_all && kept < own;
  rank(frame, verdict);
  for (const std::size_t i : ranked_) {
    if (kept >= wanted && !all) return;
    restore(verdict, i);
    ++kept;
  }
}

inline void Floor::raise_coverage(const FrameView& frame, Verdict& verdict) {
  if (params_.min_grid_coverage <= 0) return;
  lay_grid(frame);
  occupied_.assign(static_cast<std::size_t>(grid_.count()), 0);
  covered_.assign(static_cast<std::size_t>(grid_.count()), 0);
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    occupied_[cell_of(frame, i)] = 1;
    if (verdict.keep(i)) covered_[cell_of(frame, i)] = 1;
  }
  const auto count = [](const std::vector<std::uint8_t>& v) {
    return std::accumulate(v.begin(), v.end(), 0);
  };
  const int wanted = static_cast<int>(std::ceil(params_.min_grid_coverage * count(occupied_)));
  int have = count(covered_);
  if (have < wanted && ranked_.empty()) rank(frame, verdict);
  for (const std::size_t i : ranked_) {
    if (have >= wanted) return;
    std::uint8_t& cell = covered_[cell_of(frame, i)];
    if (cell != 0 || verdict.keep(i)) continue;
    cell = 1;
    ++have;
    restore(verdict, i);
  }
}

inline void Floor::lay_grid(const FrameView& frame) {
  grid_ = {static_cast<float>(frame.grey.cols), static_cast<float>(frame.grey.rows), params_.grid_columns,
           params_.grid_rows};
  if (grid_.width_px > 0) return;
  for (const cv::KeyPoint& keypoint : frame.keypoints) {
    grid_.width_px = std::max(grid_.width_px, keypoint.pt.x + 1);
    grid_.height_px = std::max(grid_.height_px, keypoint.pt.y + 1);
  }
}

}  // namespace dynfilter
