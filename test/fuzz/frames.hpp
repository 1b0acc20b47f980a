// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "bytes.hpp"

namespace fuzz {

/// Ids may be any numbers: theirs wrap.
inline std::int64_t plus(std::int64_t id, int n) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(id) +
                                   static_cast<std::uint64_t>(std::int64_t{n}));
}

/// A frame that owns what a FrameView points to.
struct OwnedFrame {
  std::int64_t id = 0;
  double timestamp_s = 0;
  std::vector<cv::KeyPoint> keypoints, undistorted, keyframe_points;
  std::vector<float> depth_m, right_u_px;
  std::vector<std::int64_t> map_point_ids;
  std::vector<cv::Point3f> map_points;
  std::vector<std::int32_t> match_index;
  std::vector<dynfilter::Detection> boxes;
  std::vector<dynfilter::KeyframeView> keyframes;
  cv::Mat descriptors, grey, right, depth, labels;
  double depth_unit_m = 0.001;
  bool depth_handed_over = false;
  dynfilter::Camera camera;
  dynfilter::Pose pose;
  dynfilter::PoseProvenance provenance = dynfilter::PoseProvenance::None;
  std::optional<dynfilter::MotionPrior> prior;
  std::int64_t match_id = -1, boxes_id = -1, mask_id = -1;
  bool has_camera = true, has_matches = false, has_boxes = false, has_mask = false;

  std::size_t size() const { return keypoints.size(); }

  dynfilter::FrameView view() {
    dynfilter::FrameView v;
    v.id = id, v.timestamp_s = timestamp_s;
    v.keypoints = keypoints, v.keypoints_undistorted = undistorted;
    v.descriptors = descriptors, v.depth_m = depth_m, v.right_u_px = right_u_px;
    v.grey = grey, v.right_grey = right;
    v.depth = depth, v.depth_unit_m = depth_unit_m, v.depth_handed_over = depth_handed_over;
    if (has_camera) v.camera = camera;
    v.T_world_camera = pose, v.pose_provenance = provenance;
    v.motion_prior = prior;
    v.map_point_ids = map_point_ids, v.map_points_world_m = map_points;
    if (!keyframe_points.empty()) {
      keyframes.assign(1, {});
      keyframes[0].id = plus(id, -1), keyframes[0].T_world_camera = pose;
      keyframes[0].keypoints_undistorted = keyframe_points;
      keyframes[0].depth_m = depth_m, keyframes[0].map_point_ids = map_point_ids;
      v.covisible_keyframes = keyframes;
    }
    if (has_matches) v.matches = dynfilter::HostMatches{match_id, match_index};
    if (has_boxes) v.detections = dynfilter::DetectionInput{boxes_id, boxes};
    if (has_mask) v.mask = dynfilter::MaskInput{mask_id, labels};
    return v;
  }
};

/// Frames of a small world: a textured wall that the camera passes, and an object in front of it that moves
/// by itself. What the fuzzer adds makes values odd, sizes disagree, and ids and stamps jump.
class Frames {
 public:
  static constexpr int kMaxFeatures = 48;

  explicit Frames(Bytes& in) : in_(in) {
    features_ = in_.below(kMaxFeatures + 1);
    size_ = {32 + 4 * in_.below(13), 24 + 4 * in_.below(10)};
    inputs_ = in_.take<std::uint16_t>();
    camera_step_px_ = in_.below(9) - 4;
    object_step_px_ = in_.below(9) - 4;
    step_s_ = (1 + in_.below(8)) / 30.0;
  }

  OwnedFrame next() {
    OwnedFrame f;
    f.id = id_, f.timestamp_s = stamp_s_;
    add_features(f);
    add_images(f);
    add_geometry(f);
    add_semantics(f);
    leave_out(f);
    for (int n = in_.below(8); n > 0; --n) make_odd(f);
    ++k_, id_ = plus(id_, 1), stamp_s_ += step_s_;
    return f;
  }

 private:
  static constexpr float kNear_m = 1.5F, kFar_m = 4.0F;

  bool on_object(int i) const { return i % 3 == 0; }
  bool has(int bit) const { return (inputs_ >> bit & 1U) == 0; }

  cv::Point2f place(int i) const {
    const float x0 = static_cast<float>((i * 37) % size_.width),
                y0 = static_cast<float>((i * 23) % size_.height);
    const auto step = static_cast<float>(on_object(i) ? camera_step_px_ + object_step_px_ : camera_step_px_);
    const float x = std::fmod(x0 + step * static_cast<float>(k_), static_cast<float>(size_.width));
    return {x < 0 ? x + static_cast<float>(size_.width) : x, y0};
  }

  void add_features(OwnedFrame& f) const {
    f.descriptors = cv::Mat(features_, 32, CV_8UC1);
    for (int i = 0; i < features_; ++i) {
      const float z = on_object(i) ? kNear_m : kFar_m;
      f.keypoints.emplace_back(place(i), 31.0F, 0.0F, 1.0F, i % 8);
      f.depth_m.push_back(z);
      f.right_u_px.push_back(f.keypoints.back().pt.x - 8.0F / z);
      f.map_point_ids.push_back(i);
      f.map_points.emplace_back(static_cast<float>(i % 7), static_cast<float>(i / 7), z);
      f.match_index.push_back(i);
      for (int b = 0; b < 32; ++b)
        f.descriptors.at<std::uint8_t>(i, b) = static_cast<std::uint8_t>((i * 131 + b * 29) * (i + b + 7));
    }
    f.undistorted = f.keypoints;
    f.keyframe_points = f.keypoints;
    f.match_id = plus(id_, -1);
    f.has_matches = has(0);
  }

  void add_images(OwnedFrame& f) const {
    f.grey = texture()(cv::Rect(64 - camera_step_px_ * (k_ % 16), 4, size_.width, size_.height)).clone();
    f.depth = cv::Mat(size_, CV_16UC1, cv::Scalar(kFar_m * 1000));
    const int x =
        std::clamp(size_.width / 3 + (camera_step_px_ + object_step_px_) * (k_ % 8), 0, size_.width - 8);
    const cv::Rect object(x, size_.height / 4, 8, size_.height / 2);
    f.depth(object).setTo(cv::Scalar(kNear_m * 1000));
    texture()(cv::Rect(10, 10, object.width, object.height)).copyTo(f.grey(object));
    if (features_ % 2 == 1) f.right = seen_from_the_right(f.grey);
    f.labels = cv::Mat::zeros(size_, CV_8UC1);
    f.labels(object).setTo(cv::Scalar(15));
    f.boxes.push_back({cv::Rect2f(object), 0, "person", 0.9F, -1, cv::Mat()});
    f.boxes.push_back({cv::Rect2f(2, 2, 12, 9), 56, "chair", 0.5F, 3, has(1) ? f.labels : cv::Mat()});
    if (has(1)) f.boxes.push_back(striped_box());
  }
  static cv::Mat seen_from_the_right(const cv::Mat& grey) {
    constexpr int kDisparity_px = 3;
    cv::Mat right = grey.clone();
    if (grey.cols > kDisparity_px)
      grey.colRange(kDisparity_px, grey.cols).copyTo(right.colRange(0, grey.cols - kDisparity_px));
    return right;
  }
  /// Half of the features in the box are on its mask.
  dynfilter::Detection striped_box() const {
    constexpr int kStripe_px = 8;
    const cv::Rect box(size_.width / 8, size_.height / 8, size_.width / 2, size_.height / 2);
    cv::Mat mask = cv::Mat::zeros(size_, CV_8UC1);
    for (int x = k_ % kStripe_px; x < size_.width; x += 2 * kStripe_px)
      mask.colRange(x, std::min(x + kStripe_px, size_.width)).setTo(cv::Scalar(1));
    return {cv::Rect2f(box), 0, "person", 0.8F, 7, mask};
  }

  void add_geometry(OwnedFrame& f) const {
    f.camera.fx_px = f.camera.fy_px = 60;
    f.camera.cx_px = size_.width / 2.0, f.camera.cy_px = size_.height / 2.0;
    f.camera.width_px = has(2) ? size_.width : 0, f.camera.height_px = has(2) ? size_.height : 0;
    f.camera.baseline_fx_px_m = has(3) ? 8 : 0;
    if (!has(4)) f.camera.distortion = {0.1, -0.05, 0.001, 0.001, 0};
    f.pose.translation_m[0] = -static_cast<double>(camera_step_px_ * k_) * kFar_m / 60;
    if (k_ % 2 == 1) {
      f.prior = dynfilter::MotionPrior::turn(Eigen::Matrix3d::Identity(), 1e-6 * Eigen::Matrix3d::Identity());
      f.prior->T_current_reference.translation_m[0] = static_cast<double>(camera_step_px_) * kFar_m / 60;
      f.prior->has_translation = k_ % 4 == 1;
      for (std::size_t i = 0; i < 3; ++i) f.prior->covariance[7 * i] = 1e-4;
    }
    f.provenance = static_cast<dynfilter::PoseProvenance>(inputs_ >> 5U & 3U);
  }

  void add_semantics(OwnedFrame& f) {
    const std::uint8_t say = in_.byte();
    f.has_boxes = (say & 1U) != 0, f.has_mask = (say & 2U) != 0;
    if ((say & 4U) != 0) f.boxes.clear();
    if ((say & 8U) != 0) f.boxes_id = f.mask_id = plus(id_, -(say >> 4U));
  }

  void leave_out(OwnedFrame& f) const {
    if (!has(7)) f.grey = cv::Mat();
    if (!has(8)) f.depth = cv::Mat();
    if (!has(9)) f.depth_m.clear();
    if (!has(10)) f.right_u_px.clear();
    if (!has(11)) f.descriptors = cv::Mat();
    if (!has(12)) f.map_point_ids.clear(), f.map_points.clear();
    if (!has(13)) f.keyframe_points.clear();
    if (!has(14)) f.undistorted.clear();
    f.has_camera = has(15);
  }

  template <class T>
  T* one_of(std::vector<T>& values) {
    const std::size_t k = in_.byte();
    return values.empty() ? nullptr : &values[k % values.size()];
  }
  float odd() {  // what does not fit becomes infinite, as in a host's arithmetic
    const double value = in_.odd();
    return std::abs(value) > 3.4e38 ? static_cast<float>(value > 0 ? INFINITY : -INFINITY)
                                    : static_cast<float>(value);
  }
  template <class T>
  void set_odd(std::vector<T>& values, float T::*member) {
    if (T* value = one_of(values)) value->*member = odd();
  }
  void set_odd_place(std::vector<cv::KeyPoint>& keypoints) {
    if (cv::KeyPoint* k = one_of(keypoints)) (in_.flag() ? k->pt.x : k->pt.y) = odd();
  }
  static void recut(cv::Mat& image, Bytes& in) {
    const int rows = in.below(40), cols = in.below(60);
    image = image.empty() || in.flag()
                ? cv::Mat(rows, cols, image.type(), cv::Scalar(in.byte()))
                : cv::Mat(image, cv::Rect(0, 0, std::min(cols, image.cols), std::min(rows, image.rows)));
  }

  void make_odd(OwnedFrame& f) {
    switch (in_.below(32)) {
      case 0:
        set_odd_place(f.keypoints);
        break;
      case 1:
        set_odd_place(f.undistorted);
        break;
      case 2:
        if (float* z = one_of(f.depth_m)) *z = odd();
        break;
      case 3:
        if (float* u = one_of(f.right_u_px)) *u = odd();
        break;
      case 4:
        if (std::int64_t* id = one_of(f.map_point_ids)) *id = in_.take<std::int64_t>();
        break;
      case 5:
        if (cv::Point3f* p = one_of(f.map_points)) (in_.flag() ? p->x : p->z) = odd();
        break;
      case 6:
        if (std::int32_t* m = one_of(f.match_index)) *m = in_.take<std::int32_t>();
        break;
      case 7:
        recut(f.grey, in_);
        break;
      case 8:
        recut(f.depth, in_);
        break;
      case 9:
        recut(f.labels, in_);
        break;
      case 10:
        recut(f.descriptors, in_);
        break;
      case 11:
        f.depth_unit_m = in_.odd();
        break;
      case 12:
        f.depth.convertTo(f.depth, CV_32F);
        break;
      case 13:
        f.grey.convertTo(f.grey, in_.flag() ? CV_16U : CV_32F);
        break;
      case 14:
        if (!f.depth.empty() && f.depth.type() == CV_32FC1)
          f.depth.at<float>(in_.byte() % f.depth.rows, in_.byte() % f.depth.cols) = odd();
        break;
      case 15:
        odd_camera(f.camera);
        break;
      case 16:
        (in_.flag() ? f.pose.translation_m[0] : f.pose.rotation[in_.byte() % 9U]) = in_.odd();
        if (f.prior && in_.flag()) f.prior->covariance[in_.byte() % 36U] = in_.odd();
        break;
      case 17:
        id_ = f.id = in_.flag() ? in_.take<std::int64_t>() : plus(id_, in_.below(5) - 2);
        break;
      case 18:
        stamp_s_ = f.timestamp_s = in_.flag() ? in_.odd() : stamp_s_ + in_.below(7) - 3;
        break;
      case 19:
        f.match_id = plus(id_, -in_.below(4));
        break;
      case 20:
        f.boxes_id = in_.flag() ? in_.take<std::int64_t>() : plus(id_, -in_.below(4));
        break;
      case 21:
        f.mask_id = in_.flag() ? in_.take<std::int64_t>() : plus(id_, -in_.below(4));
        break;
      case 22:
        odd_box(f);
        break;
      case 23:
        shorten(f);
        break;
      case 24:
        features_ = in_.below(kMaxFeatures + 1);
        break;
      case 25:
        size_ = {1 + in_.below(80), 8 + in_.below(56)}, size_.width = std::max(size_.width, 9);
        break;
      case 26:
        inputs_ = in_.take<std::uint16_t>();
        break;
      case 27:
        if (!f.grey.empty()) f.grey.setTo(cv::Scalar(in_.byte()));
        break;
      case 28:
        f.depth_handed_over = true;
        break;
      case 29:
        f.boxes.assign(in_.byte() * 8U, f.boxes.empty() ? dynfilter::Detection() : f.boxes[0]);
        break;
      case 30:
        if (cv::KeyPoint* k = one_of(f.keypoints))
          k->octave = in_.take<std::int32_t>(), k->size = odd(), k->angle = odd();
        break;
      default:
        std::swap(camera_step_px_, object_step_px_);
        break;
    }
  }
  void odd_camera(dynfilter::Camera& c) {
    double* const members[] = {
        &c.fx_px,         &c.fy_px,         &c.cx_px,         &c.cy_px,        &c.baseline_fx_px_m,
        &c.distortion[0], &c.distortion[1], &c.distortion[2], &c.distortion[4]};
    const std::size_t k = in_.byte() % (std::size(members) + 1);
    if (k < std::size(members))
      *members[k] = in_.odd();
    else
      c.width_px = in_.take<std::int32_t>(), c.height_px = in_.take<std::int32_t>();
  }
  void odd_box(OwnedFrame& f) {
    dynfilter::Detection* box = one_of(f.boxes);
    if (box == nullptr) return;
    float* const members[] = {&box->box.x, &box->box.y, &box->box.width, &box->box.height, &box->score};
    *members[in_.byte() % std::size(members)] = odd();
    if (in_.flag()) box->track_id = in_.take<std::int32_t>();
    if (in_.flag()) recut(box->mask, in_);
  }
  void shorten(OwnedFrame& f) {
    const std::size_t n = static_cast<std::size_t>(in_.below(kMaxFeatures));
    switch (in_.below(6)) {
      case 0:
        f.depth_m.resize(n);
        break;
      case 1:
        f.right_u_px.resize(n);
        break;
      case 2:
        f.undistorted.resize(n);
        break;
      case 3:
        f.map_point_ids.resize(n);
        break;
      case 4:
        f.map_points.resize(n);
        break;
      default:
        f.match_index.resize(n);
        break;
    }
  }

  /// Noise with structures of a few pixels, the same in every run.
  static const cv::Mat& texture() {
    static const cv::Mat image = [] {
      cv::Mat noise(80, 240, CV_8UC1);
      std::uint32_t state = 7;
      for (int y = 0; y < noise.rows; ++y)
        for (int x = 0; x < noise.cols; ++x)
          noise.at<std::uint8_t>(y, x) =
              static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24U);
      cv::GaussianBlur(noise, noise, {3, 3}, 0);
      return noise;
    }();
    return image;
  }

  Bytes& in_;
  int features_ = 0, camera_step_px_ = 0, object_step_px_ = 0;
  std::uint16_t inputs_ = 0;
  cv::Size size_;
  double step_s_ = 0, stamp_s_ = 0;
  std::int64_t id_ = 0;
  int k_ = 0;
};

}  // namespace fuzz
