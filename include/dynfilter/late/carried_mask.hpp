// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/late/motion_history.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// A mask or label image carried forward from the frame that it was computed on. It is a set of points, one
/// for every 4 x 4 pixels, each with its depth. Like NGD-SLAM (Zhang et al. 2024), it moves the mask by the
/// flow and depth of its features. A point moves with the nearby features of the mask at its depth. A point
/// is hidden while the depth image shows another surface, and removed if this lasts. Cost: about 0.3 ms.
class CarriedMask {
 public:
  /// `labels`: CV_8UC1 of any size. `frame`: the frame that they were computed on.
  void start(const cv::Mat& labels, const MotionFrame& frame);

  void carry(const MotionFrame& to);  ///< to the next frame, along its matches

  /// CV_8UC1 at a quarter of the image's width and height. Valid until the next call.
  /// Gaps between points are filled where at least 4 of the 8 neighbours are set.
  const cv::Mat& labels();

 private:
  static constexpr float kCellPx = MotionHistory::kCellPx;
  static constexpr int kBlock = 8;  // width and height of a block of cells that moves as one
  static constexpr float kNearPx = 60;
  // Largest depth difference between a point and its features.
  static constexpr float kLayer_m = 0.3F;
  static constexpr float kSame_m = 0.2F;  // largest depth difference on one surface
  static constexpr std::size_t kMinSamples = 3;
  static constexpr int kMaxMisses = 5;
  static constexpr int kParentAge = 3, kNeverParent = -1000000;
  // A point this many cells inside the outline is certainly on the object.
  static constexpr int kInside = 2;
  static constexpr float kGap_m = 0.2F;
  static constexpr double kMinShare = 0.2;
  static constexpr float kStepShare = 0.03F;

  struct Point {
    cv::Point2f px;
    float depth_m;
    std::uint8_t label;
    int misses;  ///< consecutive frames that show another surface here
    int age;     ///< frames
  };
  struct Motion {
    cv::Point2f px;
    float deeper_m = 0;
  };
  struct Block {
    std::vector<float> depths_m;
    int points = 0;
  };

  static cv::Point cell_of(const cv::Point2f& px) { return MotionHistory::cell_of(px); }
  bool in_grid(const cv::Point& cell) const {
    return cell.x >= 0 && cell.y >= 0 && cell.x < grid_.cols && cell.y < grid_.rows;
  }
  int blocks_across() const { return (grid_.cols + kBlock - 1) / kBlock; }
  std::size_t block_of(const cv::Point& cell) const {
    const int block = cell.y / kBlock * blocks_across() + cell.x / kBlock;
    return static_cast<std::size_t>(block);
  }
  void collect(const std::vector<MotionSample>& samples);
  void find_motions();

  /// Motion of the nearby features at this depth.
  /// Falls back to all features at this depth, then to all features on the mask.
  Motion motion_at(const cv::Point2f& px, float depth_m);

  void look(Point& p, const cv::Mat& depth_m) const;
  bool all_around(const cv::Point& cell) const;

  /// Removes background that the outline includes. Within each connected part of the mask, a depth layer is
  /// removed if it holds less than kMinShare of the points. Layers are kGap_m apart.
  void drop_small_layers();
  /// Collects the points with depth that are connected to this one. Removes them from index_.
  void take_part(const Point& first);

  /// Adds surface that a moving limb uncovers, beside points that are kParentAge frames old.
  /// Growth is slow, so that the floor under the feet does not join.
  void grow(const cv::Mat& depth_m);

  void draw() {
    grid_.setTo(cv::Scalar(0));
    for (const Point& p : points_)
      if (p.misses == 0) grid_.at<std::uint8_t>(cell_of(p.px)) = p.label;
  }

  std::vector<Point> points_;
  cv::Mat grid_, closed_, index_;
  std::vector<cv::Point> open_;
  std::vector<std::size_t> part_;
  std::vector<MotionSample> on_mask_;
  std::vector<Block> blocks_;
  std::vector<Motion> motions_;
  std::vector<float> x_, y_, z_;
};

inline void CarriedMask::start(const cv::Mat& labels, const MotionFrame& frame) {
  const int cell = MotionHistory::kCellPx;
  grid_.create((frame.image_px.height + cell - 1) / cell, (frame.image_px.width + cell - 1) / cell, CV_8UC1);
  const bool depth = frame.depth_m.size() == grid_.size();
  points_.clear();
  for (int r = 0; r < grid_.rows; ++r)
    for (int c = 0; c < grid_.cols; ++c) {
      const std::uint8_t label = labels.at<std::uint8_t>((2 * r + 1) * labels.rows / (2 * grid_.rows),
                                                         (2 * c + 1) * labels.cols / (2 * grid_.cols));
      grid_.at<std::uint8_t>(r, c) = label;
      if (label == 0) continue;
      const cv::Point2f px((static_cast<float>(c) + 0.5F) * kCellPx,
                           (static_cast<float>(r) + 0.5F) * kCellPx);
      points_.push_back(
          {px, depth ? frame.depth_m.at<float>(r, c) : DepthSampler::kNone, label, 0, kNeverParent});
    }
  for (Point& p : points_)
    if (all_around(cell_of(p.px))) p.age = kParentAge;
  drop_small_layers();
  draw();
}

inline void CarriedMask::carry(const MotionFrame& to) {
  collect(to.samples);
  find_motions();
  const bool depth = to.depth_m.size() == grid_.size();
  for (Point& p : points_) {
    const cv::Point cell = cell_of(p.px);
    const Motion& motion = motions_[block_of(cell)];
    p.px += motion.px;
    p.depth_m += motion.deeper_m;
    ++p.age;
    if (depth) look(p, to.depth_m);
  }
  points_.erase(
      std::remove_if(points_.begin(), points_.end(),
                     [&](const Point& p) { return p.misses > kMaxMisses || !in_grid(cell_of(p.px)); }),
      points_.end());
  draw();
  if (depth) grow(to.depth_m);
}

inline const cv::Mat& CarriedMask::labels() {
  grid_.copyTo(closed_);
  for (int r = 1; r + 1 < grid_.rows; ++r)
    for (int c = 1; c + 1 < grid_.cols; ++c) {
      if (grid_.at<std::uint8_t>(r, c) != 0) continue;
      int around = 0;
      std::uint8_t label = 0;
      for (int dr = -1; dr <= 1; ++dr)
        for (int dc = -1; dc <= 1; ++dc) {
          const std::uint8_t there = grid_.at<std::uint8_t>(r + dr, c + dc);
          around += there != 0 ? 1 : 0;
          label = std::max(label, there);
        }
      if (around >= 4) closed_.at<std::uint8_t>(r, c) = label;
    }
  return closed_;
}

inline void CarriedMask::collect(const std::vector<MotionSample>& samples) {
  on_mask_.clear();
  for (const MotionSample& s : samples) {
    const cv::Point cell = cell_of(s.from_px);
    if (in_grid(cell) && grid_.at<std::uint8_t>(cell) != 0) on_mask_.push_back(s);
  }
}

inline void CarriedMask::find_motions() {
  const int down = (grid_.rows + kBlock - 1) / kBlock;
  const int blocks = blocks_across() * down;
  blocks_.resize(static_cast<std::size_t>(blocks));
  motions_.assign(blocks_.size(), Motion());
  for (Block& block : blocks_) block.depths_m.clear(), block.points = 0;
  for (const Point& p : points_) {
    Block& block = blocks_[block_of(cell_of(p.px))];
    ++block.points;
    if (std::isfinite(p.depth_m)) block.depths_m.push_back(p.depth_m);
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (blocks_[b].points == 0) continue;
    const int column = static_cast<int>(b) % blocks_across(), row = static_cast<int>(b) / blocks_across();
    motions_[b] = motion_at(
        cv::Point2f(static_cast<float>(column) + 0.5F, static_cast<float>(row) + 0.5F) * (kBlock * kCellPx),
        median_in_place(blocks_[b].depths_m));
  }
}

inline CarriedMask::Motion CarriedMask::motion_at(const cv::Point2f& px, float depth_m) {
  for (const auto& [reach_px, layer_m] : {std::pair{kNearPx, kLayer_m}, {1e9F, kLayer_m}, {1e9F, 1e9F}}) {
    x_.clear(), y_.clear(), z_.clear();
    for (const MotionSample& s : on_mask_) {
      const cv::Point2f apart = s.from_px - px;
      if (apart.dot(apart) > reach_px * reach_px || std::abs(s.from_depth_m - depth_m) > layer_m) continue;
      x_.push_back(s.to_px.x - s.from_px.x);
      y_.push_back(s.to_px.y - s.from_px.y);
      const float deeper_m = s.to_depth_m - s.from_depth_m;
      if (std::abs(deeper_m) <= kLayer_m) z_.push_back(deeper_m);
    }
    if (x_.size() >= kMinSamples)
      return {{median_in_place(x_), median_in_place(y_)}, z_.empty() ? 0 : median_in_place(z_)};
  }
  return {};
}

inline void CarriedMask::look(Point& p, const cv::Mat& depth_m) const {
  const cv::Point cell = cell_of(p.px);
  if (!in_grid(cell)) return;
  const float seen = depth_m.at<float>(cell);
  if (std::isnan(seen)) return;
  const bool same = !std::isfinite(p.depth_m) || std::abs(seen - p.depth_m) <= kSame_m;
  p.misses = same ? 0 : p.misses + 1;
  if (same) p.depth_m = seen;
}

inline bool CarriedMask::all_around(const cv::Point& cell) const {
  for (int dy = -kInside; dy <= kInside; ++dy)
    for (int dx = -kInside; dx <= kInside; ++dx) {
      const cv::Point there = cell + cv::Point(dx, dy);
      if (in_grid(there) && grid_.at<std::uint8_t>(there) == 0) return false;
    }
  return true;
}

inline void CarriedMask::drop_small_layers() {
  index_.create(grid_.size(), CV_32SC1);
  index_.setTo(cv::Scalar(-1));
  for (std::size_t i = 0; i < points_.size(); ++i)
    index_.at<int>(cell_of(points_[i].px)) = static_cast<int>(i);
  for (const Point& first : points_) {
    if (index_.at<int>(cell_of(first.px)) < 0) continue;
    take_part(first);
    std::sort(part_.begin(), part_.end(), [&](std::size_t a, std::size_t b) {
      return std::pair{points_[a].depth_m, a} < std::pair{points_[b].depth_m, b};
    });
    for (std::size_t begin = 0, end = 0; begin < part_.size(); begin = end) {
      end = begin + 1;
      while (end < part_.size() && points_[part_[end]].depth_m - points_[part_[end - 1]].depth_m <= kGap_m)
        ++end;
      if (static_cast<double>(end - begin) >= kMinShare * static_cast<double>(part_.size())) continue;
      for (std::size_t k = begin; k < end; ++k) points_[part_[k]].misses = kMaxMisses + 1;
    }
  }
  points_.erase(std::remove_if(points_.begin(), points_.end(), [](const Point& p) { return p.misses > 0; }),
                points_.end());
}

inline void CarriedMask::take_part(const Point& first) {
  part_.clear();
  open_.assign(1, cell_of(first.px));
  index_.at<int>(open_[0]) = -index_.at<int>(open_[0]) - 2;
  while (!open_.empty()) {
    const cv::Point cell = open_.back();
    open_.pop_back();
    const auto i = static_cast<std::size_t>(-index_.at<int>(cell) - 2);
    if (std::isfinite(points_[i].depth_m)) part_.push_back(i);
    for (const cv::Point& step : {cv::Point(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
      const cv::Point next = cell + step;
      if (!in_grid(next) || index_.at<int>(next) < 0) continue;
      index_.at<int>(next) = -index_.at<int>(next) - 2;
      open_.push_back(next);
    }
  }
}

inline void CarriedMask::grow(const cv::Mat& depth_m) {
  const std::size_t before = points_.size();
  for (std::size_t i = 0; i < before; ++i) {
    const Point p = points_[i];
    if (p.misses > 0 || p.age < kParentAge || !std::isfinite(p.depth_m)) continue;
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const cv::Point2f px = p.px + cv::Point2f(static_cast<float>(dx), static_cast<float>(dy)) * kCellPx;
      const cv::Point cell = cell_of(px);
      if (!in_grid(cell) || grid_.at<std::uint8_t>(cell) != 0) continue;
      const float seen = depth_m.at<float>(cell);
      if (!(std::abs(seen - p.depth_m) <= kStepShare * p.depth_m)) continue;
      grid_.at<std::uint8_t>(cell) = p.label;
      points_.push_back({px, seen, p.label, 0, 0});
    }
  }
}

}  // namespace dynfilter
