// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/random.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_motion.hpp>
#include <limits>
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

inline Random ExactScene::random(Purpose purpose, int frame, std::uint64_t point) const {
  const auto place = mix_bits(static_cast<std::uint64_t>(purpose)) + static_cast<std::uint64_t>(frame);
  return Random(seed_, mix_bits(mix_bits(place) + point));
}

/// Throws ConfigError without a focal length or an image size.
inline ExactScene& ExactScene::camera(const Camera& camera) {
  if (!camera.valid() || camera.width_px < 1 || camera.height_px < 1)
    throw ConfigError("camera", "an exact scene needs a focal length and an image size");
  camera_ = camera;
  return *this;
}

inline int ExactScene::point_count() const {
  int n = points_;
  for (const MovingBox& mover : movers_) n += mover.points();
  return n;
}

inline int ExactScene::label(int p) const {
  if (p < points_) return 0;
  int label = 1;
  for (p -= points_; p >= movers_[static_cast<std::size_t>(label - 1)].points(); ++label)
    p -= movers_[static_cast<std::size_t>(label - 1)].points();
  return label;
}

inline Eigen::Vector3d ExactScene::static_position_m(int p) const {
  Random random = this->random(Purpose::Place, 0, p);
  const Eigen::Isometry3d T = camera_motion_(random.below(horizon_)).isometry();
  const double y_px = random.uniform(0, camera_.height_px - 1),
               x_px = random.uniform(0, camera_.width_px - 1);
  const cv::Point2d px(x_px, y_px);
  const Eigen::Vector3d direction = ray(camera_, px);
  const double depth_m = random.uniform(min_depth_m_, max_depth_m_);
  if (!planar_) return T * (direction * depth_m);
  const Eigen::Vector3d normal(portable::sin(0.35), 0, portable::cos(0.35)), on_wall(0, 0, 3);
  return T * (direction * (normal.dot(on_wall - T.translation()) / normal.dot(T.linear() * direction)));
}

inline Eigen::Vector3d ExactScene::position_m(int p, int k) const {
  const int l = label(p);
  if (l == 0) return static_position_m(p);
  const MovingBox& mover = movers_[static_cast<std::size_t>(l - 1)];
  Random random = this->random(Purpose::Place, l, p);
  Eigen::Vector3d offset;
  for (int axis = 0; axis < 3; ++axis) offset[axis] = random.uniform(-1, 1) * mover.half_size_m()[axis];
  return mover.T_world_object(k) * offset;
}

/// True if the box of another mover is on the line of sight.
inline bool ExactScene::hidden(int p, const Eigen::Vector3d& point_m, int k) const {
  const Eigen::Vector3d eye = camera_motion_(k).t();
  const int own = label(p);
  for (std::size_t m = 0; m < movers_.size(); ++m) {
    if (static_cast<int>(m) + 1 == own) continue;
    const Eigen::Isometry3d T = movers_[m].T_world_object(k).inverse();
    const Eigen::Vector3d from = T * eye, way = T * point_m - from, half = movers_[m].half_size_m();
    double enter = 0, leave = 1;
    for (int axis = 0; axis < 3 && enter <= leave; ++axis) {
      if (std::abs(way[axis]) < 1e-12) {
        if (std::abs(from[axis]) > half[axis]) leave = -1;
        continue;
      }
      const double a = (-half[axis] - from[axis]) / way[axis], b = (half[axis] - from[axis]) / way[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter <= leave) return true;
  }
  return false;
}

inline std::vector<ExactScene::Feature> ExactScene::visible(int k) const {
  const Eigen::Isometry3d T_camera_world = camera_motion_(k).isometry().inverse();
  std::vector<Feature> features;
  for (int p = 0; p < point_count(); ++p) {
    const Eigen::Vector3d world_m = position_m(p, k), point_m = T_camera_world * world_m;
    cv::Point2d px = project(camera_, point_m);
    Random random = this->random(Purpose::Pixel, k, p);
    px.x += pixel_noise_px_ * random.gaussian();
    px.y += pixel_noise_px_ * random.gaussian();
    if (in_image(camera_, distort(camera_, px)) && !hidden(p, world_m, k))
      features.push_back({p, px, point_m.z()});
  }
  if (order_seed_ == 0) return features;
  Random random = this->random(Purpose::Order, k, order_seed_);
  for (std::size_t i = features.size(); i > 1; --i)
    std::swap(features[i - 1], features[static_cast<std::size_t>(random.below(static_cast<int>(i)))]);
  return features;
}

inline Truth ExactScene::truth_of(int p, int k) const {
  const Eigen::Vector3d now = position_m(p, k), before = position_m(p, std::max(0, k - truth_frames_));
  const double moved_m = (now - before).norm();
  if (moved_m < 1e-9) return Truth::Static;
  const Eigen::Isometry3d T_camera_world = camera_motion_(k).isometry().inverse();
  const cv::Point2d miss = project(camera_, T_camera_world * now) - project(camera_, T_camera_world * before);
  return moved_m > 0.010 && !(portable::hypot(miss.x, miss.y) <= 1) ? Truth::Dynamic : Truth::DontCare;
}

inline ExactFrame ExactScene::frame(int k) const {
  ExactFrame out;
  out.id = k;
  out.timestamp_s = k / rate_hz_;
  out.camera = camera_;
  out.T_world_camera = camera_motion_(k);
  out.pose_provenance = pose_provenance_;
  for (const Feature& feature : visible(k)) add(feature, k, out);
  if (with_matches_ && k >= gap_) add_matches(k, out);
  if (with_descriptors_) add_descriptors(k, out);
  if (with_detections_ && k >= late_frames_) {
    out.detections = detections(k - late_frames_);
    out.detections_frame_id = k - late_frames_;
  }
  return out;
}

inline void ExactScene::add(const Feature& feature, int k, ExactFrame& out) const {
  const int p = feature.point, octave = random(Purpose::Place, -1, p).below(4);
  const cv::Point2f px(distort(camera_, feature.px));
  out.keypoints.emplace_back(px, 31.0F, -1.0F, 1.0F, octave);
  if (camera_.distorted())
    out.keypoints_undistorted.emplace_back(cv::Point2f(feature.px), 31.0F, -1.0F, 1.0F, octave);
  add_depth(feature, k, out);
  if (with_map_points_) {
    const Eigen::Vector3d at_m = position_m(p, 0);
    out.map_point_ids.push_back(p);
    out.map_points_world_m.emplace_back(static_cast<float>(at_m.x()), static_cast<float>(at_m.y()),
                                        static_cast<float>(at_m.z()));
  }
  out.point.push_back(p);
  out.label.push_back(label(p));
  out.truth.push_back(truth_of(p, k));
  out.mismatched.push_back(0);
}

inline void ExactScene::add_depth(const Feature& feature, int k, ExactFrame& out) const {
  if (mono_) return;
  const double noise = random(Purpose::Depth, k, feature.point).gaussian();
  const bool missing = random(Purpose::NoDepth, k, feature.point).uniform() < missing_depth_;
  const auto known = [&](double value) {
    return missing ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(value);
  };
  if (stereo_)
    out.right_u_px.push_back(
        known(feature.px.x - camera_.baseline_fx_px_m / feature.depth_m + disparity_noise_px_ * noise));
  else
    out.depth_m.push_back(
        known(feature.depth_m + depth_noise_m_ * feature.depth_m * feature.depth_m * noise));
}

inline void ExactScene::add_matches(int k, ExactFrame& out) const {
  const std::vector<Feature> reference = visible(k - gap_);
  std::vector<std::int32_t> index_of(static_cast<std::size_t>(point_count()), -1);
  for (std::size_t j = 0; j < reference.size(); ++j)
    index_of[static_cast<std::size_t>(reference[j].point)] = static_cast<std::int32_t>(j);
  out.reference_frame_id = k - gap_;
  for (std::size_t i = 0; i < out.size(); ++i) {
    std::int32_t index = index_of[static_cast<std::size_t>(out.point[i])];
    Random random = this->random(Purpose::Match, k, out.point[i]);
    if (index >= 0 && random.uniform() < missing_matches_) index = -1;
    if (index >= 0 && reference.size() > 1 && random.uniform() < mismatches_) {
      const auto n = static_cast<int>(reference.size());
      index = (index + 1 + random.below(n - 1)) % n;
      out.mismatched[i] = 1;
    }
    out.reference_index.push_back(index);
  }
}

inline void ExactScene::add_descriptors(int k, ExactFrame& out) const {
  out.descriptors.create(static_cast<int>(out.size()), 32, CV_8UC1);
  for (std::size_t i = 0; i < out.size(); ++i) {
    Random random = this->random(Purpose::Descriptor, 0, out.point[i]);
    unsigned char* row = out.descriptors.ptr(static_cast<int>(i));
    for (int b = 0; b < 32; ++b) row[b] = static_cast<unsigned char>(random.next() >> 56U);
    Random flip = this->random(Purpose::Flip, k, out.point[i]);
    for (int n = 0; n < flipped_bits_; ++n) {
      const auto bit = static_cast<unsigned>(flip.below(256));
      row[bit / 8] = static_cast<unsigned char>(row[bit / 8] ^ (1U << (bit % 8)));
    }
  }
}

/// Boxes around the corners of each mover, clipped to the image.
inline std::vector<Detection> ExactScene::detections(int k) const {
  const Eigen::Isometry3d T_camera_world = camera_motion_(k).isometry().inverse();
  std::vector<Detection> found;
  for (std::size_t m = 0; m < movers_.size(); ++m) {
    cv::Point2d low(1e9, 1e9), high(-1e9, -1e9);
    bool behind = false;
    for (int corner = 0; corner < 8; ++corner) {
      Eigen::Vector3d offset = movers_[m].half_size_m();
      for (int axis = 0; axis < 3; ++axis)
        if (((corner >> axis) & 1) != 0) offset[axis] = -offset[axis];
      const cv::Point2d px =
          distort(camera_, project(camera_, T_camera_world * (movers_[m].T_world_object(k) * offset)));
      behind = behind || std::isnan(px.x);
      low = {std::min(low.x, px.x), std::min(low.y, px.y)};
      high = {std::max(high.x, px.x), std::max(high.y, px.y)};
    }
    const cv::Rect2d image(0, 0, camera_.width_px, camera_.height_px);
    const cv::Rect2d box = cv::Rect2d(low, high) & image;
    if (behind || box.empty()) continue;
    Detection detection;
    detection.box = cv::Rect2f(box);
    detection.class_id = 0;
    detection.class_name = movers_[m].class_name();
    detection.track_id = static_cast<int>(m) + 1;
    found.push_back(std::move(detection));
  }
  return found;
}

}  // namespace dynfilter::testing
