// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

/// What another view shows at the predicted position of a point.
enum class SeenThere {
  Nothing,  ///< outside the view, or no depth around the position
  Surface,  ///< a surface at the point's depth: the point was there
  Beyond,   ///< only farther depths: the point was not there
  Nearer    ///< a nearer surface or a depth edge: undecided
};

/// Looks up depths of another view around single positions.
/// Uses its depth image, or the depths of its keypoints without an image.
class SeenDepth {
 public:
  static constexpr float kKeypointRadiusPx = 8;

  void from(const PastFrame& frame);
  /// Uses keypoints only, on undistorted pixels of the current camera.
  void from(const KeyframeView& keyframe, const Camera& camera);

  bool has_image() const { return !image_.empty(); }
  /// The frame that it came from can then reuse its image.
  void forget_image() { image_ = DepthImage(); }

  /// `deviation(z)` is signed: how much farther than the point a depth z [m] is. Values within +- `limit`
  /// agree. A pixel at an edge belongs to either surface, so a whole patch decides. One agreeing depth gives
  /// Surface; Beyond requires that all depths are beyond. `smallest` is the deviation closest to zero.
  template <class Deviation>
  SeenThere look(const cv::Point3f& point_m, int patch_px, double limit, const Deviation& deviation,
                 double& smallest) const {
    if (!camera_.valid()) return SeenThere::Nothing;
    cv::Point2f px = project(camera_, point_m);
    if (distorted_) px = distort_point(camera_, px);
    if (!(px.x >= -0.5F && px.y >= -0.5F && px.x < 1e5F && px.y < 1e5F)) return SeenThere::Nothing;
    Tally tally{limit, 1e9};
    const auto add = [&](float z_m) { tally.add(deviation(static_cast<double>(z_m))); };
    const int wanted = image_.empty() ? sample_keypoints(px, add) : sample_image(px, patch_px, add);
    smallest = tally.smallest;
    return tally.verdict(wanted);
  }

 private:
  struct Tally {
    double limit, smallest;
    int known = 0, agreeing = 0, beyond = 0;

    void add(double deviation);
    SeenThere verdict(int wanted) const {
      if (agreeing > 0) return SeenThere::Surface;
      if (known < wanted) return SeenThere::Nothing;
      return beyond == known ? SeenThere::Beyond : SeenThere::Nearer;
    }
  };

  void set_keypoints(Span<const cv::KeyPoint> keypoints, Span<const float> depth_m) {
    keypoints_ = keypoints.size() == depth_m.size() ? keypoints : Span<const cv::KeyPoint>();
    keypoint_depth_m_ = depth_m;
    grid_.build(keypoints_, 2 * kKeypointRadiusPx);
  }

  /// Both return how many depths an answer requires: half of the patch, or two keypoints.
  /// A single keypoint may be on the other side of an edge.
  template <class Add>
  int sample_image(const cv::Point2f& px, int patch_px, const Add& add) const {
    const int x = cvRound(px.x), y = cvRound(px.y);
    const int x0 = std::max(x - patch_px, 0), x1 = std::min(x + patch_px, image_.cols() - 1);
    const int y0 = std::max(y - patch_px, 0), y1 = std::min(y + patch_px, image_.rows() - 1);
    for (int r = y0; r <= y1; ++r)
      for (int c = x0; c <= x1; ++c) {
        const float z_m = image_.at(c, r);
        if (valid_depth(z_m)) add(z_m);
      }
    const int side = 2 * patch_px + 1;
    return (side * side + 1) / 2;
  }
  template <class Add>
  int sample_keypoints(const cv::Point2f& px, const Add& add) const {
    if (!grid_.empty())
      grid_.around(px, kKeypointRadiusPx, [&](std::int32_t k) {
        const auto index = static_cast<std::size_t>(k);
        const cv::Point2f off = keypoints_[index].pt - px;
        if (off.dot(off) <= kKeypointRadiusPx * kKeypointRadiusPx && valid_depth(keypoint_depth_m_[index]))
          add(keypoint_depth_m_[index]);
      });
    return 2;
  }

  Camera camera_;
  DepthImage image_;
  bool distorted_ = true;
  Span<const cv::KeyPoint> keypoints_;
  Span<const float> keypoint_depth_m_;
  PointGrid grid_;
};

inline void SeenDepth::from(const PastFrame& frame) {
  camera_ = frame.camera.value_or(Camera());
  image_ = DepthImage(frame.depth, frame.depth_unit_m);
  distorted_ = true;
  set_keypoints(image_.empty() ? Span<const cv::KeyPoint>(frame.keypoints) : Span<const cv::KeyPoint>(),
                frame.depth_m);
}

inline void SeenDepth::from(const KeyframeView& keyframe, const Camera& camera) {
  camera_ = camera;
  image_ = DepthImage();
  distorted_ = false;
  set_keypoints(keyframe.keypoints_undistorted, keyframe.depth_m);
}

inline void SeenDepth::Tally::add(double deviation) {
  if (!std::isfinite(deviation)) return;
  ++known;
  agreeing += std::abs(deviation) <= limit ? 1 : 0;
  beyond += deviation > limit ? 1 : 0;
  if (std::abs(deviation) < std::abs(smallest)) smallest = deviation;
}

}  // namespace dynfilter
