// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/testing/exact_scene.hpp>

#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <limits>

namespace dynfilter::testing {

DYNFILTER_INLINE Random ExactScene::random(Purpose purpose, int frame, std::uint64_t point) const {
  const auto place = mix_bits(static_cast<std::uint64_t>(purpose)) + static_cast<std::uint64_t>(frame);
  return Random(seed_, mix_bits(mix_bits(place) + point));
}

/// Throws ConfigError without a focal length or an image size.
DYNFILTER_INLINE ExactScene& ExactScene::camera(const Camera& camera) {
  if (!camera.valid() || camera.width_px < 1 || camera.height_px < 1)
    throw ConfigError("camera", "an exact scene needs a focal length and an image size");
  camera_ = camera;
  return *this;
}

DYNFILTER_INLINE int ExactScene::point_count() const {
  int n = points_;
  for (const MovingBox& mover : movers_) n += mover.points();
  return n;
}

DYNFILTER_INLINE int ExactScene::label(int p) const {
  if (p < points_) return 0;
  int label = 1;
  for (p -= points_; p >= movers_[static_cast<std::size_t>(label - 1)].points(); ++label)
    p -= movers_[static_cast<std::size_t>(label - 1)].points();
  return label;
}

DYNFILTER_INLINE Eigen::Vector3d ExactScene::static_position_m(int p) const {
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

DYNFILTER_INLINE Eigen::Vector3d ExactScene::position_m(int p, int k) const {
  const int l = label(p);
  if (l == 0) return static_position_m(p);
  const MovingBox& mover = movers_[static_cast<std::size_t>(l - 1)];
  Random random = this->random(Purpose::Place, l, p);
  Eigen::Vector3d offset;
  for (int axis = 0; axis < 3; ++axis) offset[axis] = random.uniform(-1, 1) * mover.half_size_m()[axis];
  return mover.T_world_object(k) * offset;
}

/// True if the box of another mover is on the line of sight.
DYNFILTER_INLINE bool ExactScene::hidden(int p, const Eigen::Vector3d& point_m, int k) const {
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

DYNFILTER_INLINE std::vector<ExactScene::Feature> ExactScene::visible(int k) const {
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

DYNFILTER_INLINE Truth ExactScene::truth_of(int p, int k) const {
  const Eigen::Vector3d now = position_m(p, k), before = position_m(p, std::max(0, k - truth_frames_));
  const double moved_m = (now - before).norm();
  if (moved_m < 1e-9) return Truth::Static;
  const Eigen::Isometry3d T_camera_world = camera_motion_(k).isometry().inverse();
  const cv::Point2d miss = project(camera_, T_camera_world * now) - project(camera_, T_camera_world * before);
  return moved_m > 0.010 && !(portable::hypot(miss.x, miss.y) <= 1) ? Truth::Dynamic : Truth::DontCare;
}

DYNFILTER_INLINE ExactFrame ExactScene::frame(int k) const {
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

DYNFILTER_INLINE void ExactScene::add(const Feature& feature, int k, ExactFrame& out) const {
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

DYNFILTER_INLINE void ExactScene::add_depth(const Feature& feature, int k, ExactFrame& out) const {
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

DYNFILTER_INLINE void ExactScene::add_matches(int k, ExactFrame& out) const {
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

DYNFILTER_INLINE void ExactScene::add_descriptors(int k, ExactFrame& out) const {
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
DYNFILTER_INLINE std::vector<Detection> ExactScene::detections(int k) const {
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
