// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

namespace dynfilter_test {

/// A frame with every input that a host may have. Arrays are parallel to `keypoints`.
struct LayeredFrame {
  std::int64_t id = 0;
  double timestamp_s = 0;
  std::vector<cv::KeyPoint> keypoints;
  std::vector<int> point;           ///< of the scene, the same in all frames
  std::vector<std::uint8_t> moves;  ///< 1: on the mover
  std::vector<float> depth_m, right_u_px;
  cv::Mat descriptors;
  std::vector<std::int64_t> map_point_ids;
  std::vector<cv::Point3f> map_points_world_m;
  std::vector<std::int32_t> reference_index;  ///< in the last frame
  cv::Mat grey, depth;                        ///< CV_8UC1, CV_32FC1 [m]
  cv::Mat labels;                             ///< CV_8UC1, the mover is 1
  std::vector<dynfilter::Detection> boxes;    ///< of the mover
  dynfilter::Pose T_world_camera;

  std::size_t size() const { return keypoints.size(); }
};

/// A camera that slides to the right along a far and a near wall, with a mover that falls in front.
/// Everything moves by whole pixels, so depths, columns and poses are exact in float.
class LayeredScene {
 public:
  static constexpr int kWidth = 320, kHeight = 240, kFrames = 8;
  static constexpr double kFocal_px = 250, kCentreX_px = 160, kCentreY_px = 120;
  /// Baseline [m] times focal length [px].
  static constexpr double kBaseline_px_m = 32;

  LayeredScene() : far_(texture(1)), near_(texture(2)), mover_(texture(3)) {
    add_points(kFarStep_px, {0, 0, kWidth + kFarStep_px * kFrames, kHalf}, false);
    add_points(kNearStep_px, {0, kHalf, kWidth + kNearStep_px * kFrames, kHalf}, false);
    add_points(0, {kMoverX, kMoverY, kMoverWidth, kMoverHeight}, true);
  }

  dynfilter::Camera camera() const {
    dynfilter::Camera camera;
    camera.fx_px = camera.fy_px = kFocal_px, camera.cx_px = kCentreX_px, camera.cy_px = kCentreY_px;
    camera.baseline_fx_px_m = kBaseline_px_m;
    camera.width_px = kWidth, camera.height_px = kHeight;
    return camera;
  }

  LayeredFrame frame(int k) const {
    LayeredFrame f;
    f.id = k, f.timestamp_s = 0.04 * k;
    // A wall at z slides by f b / z. The near one is at 2 m and slides by 4 px per frame.
    f.T_world_camera.translation_m[0] = kNearStep_px * kNear_m / kFocal_px * k;
    draw(k, f);
    const std::vector<int> before = k > 0 ? visible(k - 1) : std::vector<int>();
    const std::vector<int> now = visible(k);
    f.descriptors.create(static_cast<int>(now.size()), 32, CV_8UC1);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const Point& p = points_[static_cast<std::size_t>(now[i])];
      f.point.push_back(now[i]);
      f.moves.push_back(p.moves ? 1 : 0);
      f.keypoints.emplace_back(place(p, k), 31.0F, 0.0F, 1.0F, 0);
      f.depth_m.push_back(static_cast<float>(depth_m(p)));
      f.right_u_px.push_back(f.keypoints[i].pt.x - static_cast<float>(kBaseline_px_m / depth_m(p)));
      f.map_point_ids.push_back(now[i]);
      f.map_points_world_m.push_back(world_m(p));
      describe(now[i], f.descriptors.row(static_cast<int>(i)));
      const auto then = std::find(before.begin(), before.end(), now[i]);
      f.reference_index.push_back(then == before.end() ? -1
                                                       : static_cast<std::int32_t>(then - before.begin()));
    }
    return f;
  }

 private:
  static constexpr int kHalf = kHeight / 2, kFarStep_px = 2, kNearStep_px = 4, kFall_px = 3, kSpacing_px = 12;
  static constexpr int kMoverX = 120, kMoverY = 60, kMoverWidth = 60, kMoverHeight = 84;
  static constexpr double kFar_m = 4, kNear_m = 2, kMover_m = 1;

  struct Point {
    cv::Point at;  ///< in frame 0
    int step_px;
    bool moves;
  };

  /// Blobs of 4 px, so that optical flow finds them again at all levels.
  static cv::Mat texture(unsigned seed) {
    constexpr int kBlob_px = 4;
    cv::Mat noise(kHeight / kBlob_px, 2 * kWidth / kBlob_px, CV_8UC1), image;
    std::mt19937 random(seed);
    for (int y = 0; y < noise.rows; ++y)
      for (int x = 0; x < noise.cols; ++x) noise.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random());
    cv::resize(noise, image, cv::Size(), kBlob_px, kBlob_px, cv::INTER_LINEAR);
    return image;
  }

  void add_points(int step_px, const cv::Rect& region, bool moves) {
    for (int y = region.y + kSpacing_px / 2; y < region.y + region.height; y += kSpacing_px)
      for (int x = region.x + kSpacing_px / 2; x < region.x + region.width; x += kSpacing_px)
        points_.push_back({{x, y}, step_px, moves});
  }
  static cv::Rect mover_at(int k) { return {kMoverX, kMoverY + kFall_px * k, kMoverWidth, kMoverHeight}; }
  static double depth_m(const Point& p) {
    return p.moves ? kMover_m : p.step_px == kFarStep_px ? kFar_m : kNear_m;
  }
  static cv::Point2f place(const Point& p, int k) {
    return p.moves ? cv::Point2f(cv::Point(p.at.x, p.at.y + kFall_px * k))
                   : cv::Point2f(cv::Point(p.at.x - p.step_px * k, p.at.y));
  }
  /// Where it was in frame 0, whose camera is the world.
  static cv::Point3f world_m(const Point& p) {
    const double z = depth_m(p);
    return {static_cast<float>((p.at.x - kCentreX_px) / kFocal_px * z),
            static_cast<float>((p.at.y - kCentreY_px) / kFocal_px * z), static_cast<float>(z)};
  }
  std::vector<int> visible(int k) const {
    constexpr int kBorder_px = 4;
    std::vector<int> indices;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const cv::Point at(place(points_[i], k));
      const bool inside = at.x >= kBorder_px && at.x < kWidth - kBorder_px && at.y < kHeight - kBorder_px;
      if (inside && (points_[i].moves || !mover_at(k).contains(at))) indices.push_back(static_cast<int>(i));
    }
    return indices;
  }
  static void describe(int point, cv::Mat row) {
    std::mt19937 random(static_cast<unsigned>(point));
    for (int c = 0; c < row.cols; ++c) row.at<std::uint8_t>(0, c) = static_cast<std::uint8_t>(random());
  }

  void draw(int k, LayeredFrame& f) const {
    const cv::Rect top(0, 0, kWidth, kHalf), bottom(0, kHalf, kWidth, kHeight - kHalf);
    const cv::Rect mover = mover_at(k) & cv::Rect(0, 0, kWidth, kHeight);
    f.grey.create(kHeight, kWidth, CV_8UC1), f.depth.create(kHeight, kWidth, CV_32FC1);
    far_(top + cv::Point(kFarStep_px * k, 0)).copyTo(f.grey(top));
    near_(bottom + cv::Point(kNearStep_px * k, 0)).copyTo(f.grey(bottom));
    mover_(cv::Rect(0, 0, mover.width, mover.height)).copyTo(f.grey(mover));
    f.depth(top).setTo(kFar_m), f.depth(bottom).setTo(kNear_m), f.depth(mover).setTo(kMover_m);
    f.labels = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
    f.labels(mover).setTo(1);
    f.boxes = {{cv::Rect2f(mover), 0, "person", 0.9F, -1, cv::Mat()}};
  }

  cv::Mat far_, near_, mover_;
  std::vector<Point> points_;
};

/// The names of all presets that a host can run.
inline std::vector<std::string> host_presets(std::vector<std::string> all) {
  all.erase(std::remove(all.begin(), all.end(), "oracle"), all.end());  // only the command has it
  return all;
}

}  // namespace dynfilter_test
