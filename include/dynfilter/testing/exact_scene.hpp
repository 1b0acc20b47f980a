// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/random.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter::testing {

/// A small scene without images and with exact truth: points, movers and a camera. It provides the inputs
/// that a host has in each frame. Deterministic per seed. Frames can be computed in any order.
///
///   ExactScene scene = ExactScene().points(300).mover(MovingBox(60).moving({0.05, 0, 0}));
///   const ExactFrame frame = scene.frame(5);   // with matches to frame 4
///   filter.apply(...frame.view()...);          // or testing/judge.hpp
///   scene.is_dynamic(5, i);
class ExactScene {
 public:
  ExactScene() : camera_motion_(steady_motion(CameraStep::General)) {}

  // ---- content
  /// Number of static points. Each is in view in at least one of the first `horizon` frames.
  ExactScene& points(int n) { return points_ = std::max(0, n), *this; }
  ExactScene& seed(std::uint64_t seed) { return seed_ = seed, *this; }  ///< the default is 1
  /// Of the static points [m].
  ExactScene& depth_range(double min_m, double max_m) {
    return min_depth_m_ = min_m, max_depth_m_ = max_m, *this;
  }
  /// Puts all static points on one wall 3 m ahead, rotated by 20 degrees.
  ExactScene& planar() { return planar_ = true, *this; }
  ExactScene& mover(MovingBox mover) { return movers_.push_back(std::move(mover)), *this; }  ///< adds one
  ExactScene& camera(const Camera& camera);  ///< throws ConfigError without focal lengths or size
  /// Of the default scene: General.
  ExactScene& camera_motion(CameraStep preset) { return camera_motion(steady_motion(preset)); }
  /// Of the camera, in the world [m].
  ExactScene& camera_motion(Motion T_world_camera) {
    return camera_motion_ = std::move(T_world_camera), *this;
  }
  ExactScene& horizon(int frames) { return horizon_ = std::max(1, frames), *this; }  ///< see points()

  // ---- errors
  /// Standard deviation of each coordinate [px].
  ExactScene& pixel_noise(double sigma_px) { return pixel_noise_px_ = sigma_px, *this; }
  /// Standard deviation at one metre, which grows with the square of the depth.
  /// 0.0014 for a Kinect (Khoshelham and Elberink 2012).
  ExactScene& depth_noise(double sigma_at_1m_m) { return depth_noise_m_ = sigma_at_1m_m, *this; }
  /// Share of the features without depth.
  ExactScene& missing_depth(double share) { return missing_depth_ = share, *this; }
  /// Share of the matches that lead to a wrong feature.
  ExactScene& mismatches(double share) { return mismatches_ = share, *this; }
  /// Share of the features without a match.
  ExactScene& missing_matches(double share) { return missing_matches_ = share, *this; }

  // ---- optional inputs, besides keypoints, camera, depth and matches
  /// A stereo camera instead of depths: columns in the right image, with constant noise of the disparity.
  ExactScene& stereo(double baseline_m, double disparity_noise_px = 0) {
    camera_.baseline_fx_px_m = baseline_m * camera_.fx_px;
    return stereo_ = true, disparity_noise_px_ = disparity_noise_px, *this;
  }
  ExactScene& rate_hz(double rate_hz) { return rate_hz_ = rate_hz, *this; }  ///< frames per second
  ExactScene& mono() { return mono_ = true, *this; }                         ///< without depth
  /// Provides the true poses with this provenance.
  ExactScene& with_poses(PoseProvenance provenance = PoseProvenance::Estimated) {
    return pose_provenance_ = provenance, *this;
  }
  /// Provides a box around each mover, computed on the frame `late_frames` before.
  ExactScene& with_detections(int late_frames = 0) {
    return with_detections_ = true, late_frames_ = std::max(0, late_frames), *this;
  }
  /// Provides 256-bit descriptors, of which `flipped_bits` differ between views.
  ExactScene& with_descriptors(int flipped_bits = 10) {
    return with_descriptors_ = true, flipped_bits_ = std::clamp(flipped_bits, 0, 256), *this;
  }
  /// Provides map points at the positions of frame 0.
  ExactScene& with_map_points() { return with_map_points_ = true, *this; }
  ExactScene& without_matches() { return with_matches_ = false, *this; }  ///< the filter has to find them
  /// Number of frames between a frame and the reference of its matches.
  ExactScene& gap(int frames) { return gap_ = std::max(1, frames), *this; }
  /// Shuffles the features of every frame, differently per `seed`. 0: order of the points.
  ExactScene& order(std::uint64_t seed) { return order_seed_ = seed, *this; }
  /// Number of frames over which motion is measured to call a point dynamic.
  ExactScene& truth_over(int frames) { return truth_frames_ = std::max(1, frames), *this; }

  // ---- results
  /// Frame k >= 0. Omits features outside the image, behind the camera or behind a mover's box.
  ExactFrame frame(int k) const;
  /// Of a feature of frame k.
  Truth truth(int k, std::size_t feature) const { return frame(k).truth.at(feature); }
  /// Of a feature of frame k.
  bool is_dynamic(int k, std::size_t feature) const { return truth(k, feature) == Truth::Dynamic; }
  Pose T_world_camera(int k) const { return camera_motion_(k); }  ///< of frame k, the true one, in metres
  /// Position of point p (ExactFrame::point) at frame k, in the world [m].
  Eigen::Vector3d position_m(int p, int k) const;
  int point_count() const;  ///< of the background and of all movers
  /// 0: static background, m: mover m.
  int label(int p) const;
  const Camera& camera() const { return camera_; }                  ///< of every frame
  const std::vector<MovingBox>& movers() const { return movers_; }  ///< in the order of their labels
  int gap() const { return gap_; }  ///< frames between a frame and its reference

 private:
  enum class Purpose : std::uint64_t { Place = 1, Pixel, Depth, NoDepth, Match, Order, Descriptor, Flip };
  struct Feature {
    int point;
    cv::Point2d px;  // undistorted, with noise
    double depth_m;  // without noise
  };

  /// Depends on position instead of order, so that every frame can be computed alone.
  Random random(Purpose purpose, int frame, std::uint64_t point) const;
  Random random(Purpose purpose, int frame, int point) const {
    return random(purpose, frame, static_cast<std::uint64_t>(point));
  }
  Eigen::Vector3d static_position_m(int p) const;
  std::vector<Feature> visible(int k) const;
  bool hidden(int p, const Eigen::Vector3d& point_m, int k) const;
  Truth truth_of(int p, int k) const;
  void add(const Feature& feature, int k, ExactFrame& out) const;
  void add_depth(const Feature& feature, int k, ExactFrame& out) const;
  void add_matches(int k, ExactFrame& out) const;
  void add_descriptors(int k, ExactFrame& out) const;
  std::vector<Detection> detections(int k) const;

  Camera camera_ = freiburg3_camera();
  Motion camera_motion_;
  std::vector<MovingBox> movers_;
  int points_ = 300, horizon_ = 20, gap_ = 1, truth_frames_ = 5, late_frames_ = 0, flipped_bits_ = 10;
  std::uint64_t seed_ = 1, order_seed_ = 1;
  double min_depth_m_ = 1.5, max_depth_m_ = 5;
  double pixel_noise_px_ = 0, depth_noise_m_ = 0, missing_depth_ = 0, mismatches_ = 0, missing_matches_ = 0;
  PoseProvenance pose_provenance_ = PoseProvenance::None;
  double disparity_noise_px_ = 0, rate_hz_ = 30;
  bool planar_ = false, mono_ = false, stereo_ = false, with_detections_ = false, with_descriptors_ = false,
       with_map_points_ = false, with_matches_ = true;
};

}  // namespace dynfilter::testing

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/testing/detail/exact_scene-inl.hpp>
#endif
