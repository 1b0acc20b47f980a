// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/late/motion_history.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// A mask or label image carried forward from the frame that it was computed on.
/// It is a set of points, one for every 4 x 4 pixels, each with its depth.
/// Like NGD-SLAM (Zhang et al. 2024), it moves the mask by the flow and depth of its features.
/// A point moves with the nearby features of the mask at its depth.
/// A point is hidden while the depth image shows another surface, and removed if this lasts.
/// Cost: about 0.3 ms per frame.
class CarriedMask {
 public:
  /// `labels`: CV_8UC1 of any size. `frame`: the frame that they were computed on.
  void start(const cv::Mat& labels, const MotionFrame& frame);

  void carry(const MotionFrame& to);

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
  std::size_t block_of(const cv::Point& cell) const;

  void collect(const std::vector<MotionSample>& samples);

  void find_motions();

  /// Motion of the nearby features at this depth.
  /// Falls back to all features at this depth, then to all features on the mask.
  Motion motion_at(const cv::Point2f& px, float depth_m);

  void look(Point& p, const cv::Mat& depth_m) const;

  bool all_around(const cv::Point& cell) const;

  /// Removes background that the outline includes.
  /// Within each connected part of the mask, a depth layer is removed
  /// if it holds less than kMinShare of the points. Layers are kGap_m apart.
  void drop_small_layers();
  /// Collects the points with depth that are connected to this one. Removes them from index_.
  void take_part(const Point& first);

  /// Adds surface that a moving limb uncovers, beside points that are kParentAge frames old.
  /// Growth is slow, so that the floor under the feet does not join.
  void grow(const cv::Mat& depth_m);

  void draw();

  std::vector<Point> points_;
  cv::Mat grid_, closed_, index_;
  std::vector<cv::Point> open_;
  std::vector<std::size_t> part_;
  std::vector<MotionSample> on_mask_;
  std::vector<Block> blocks_;
  std::vector<Motion> motions_;
  std::vector<float> x_, y_, z_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/late/detail/carried_mask-inl.hpp>
#endif
