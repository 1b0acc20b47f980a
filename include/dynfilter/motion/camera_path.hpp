// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/motion/row_twist.hpp>
#include <vector>

namespace dynfilter {

/// How the camera moved over the last frames, against the background. Gaps count frames backwards from the
/// current one. The world is the first camera.
class CameraPath {
 public:
  static constexpr std::size_t kMaxFrames = 12;  ///< that it goes back, at most ...
  static constexpr double kWindow_s = 0.2;       ///< ... and in time

  /// What was measured of a step, with the motion.
  struct Step {
    double match_noise_px = 0;  ///< that neighbours do not share
    RowTwist twist;
  };

  void reset() {
    forget_motion();
    frames_.clear();
  }
  /// Frames and their times stay.
  void forget_motion() {
    poses_.clear();
    steps_.clear();
    unbroken_ = 0;
  }
  /// A frame begins, of which the motion is not known yet.
  void begin(const FrameView& frame) {
    frames_.insert(frames_.begin(), {frame.timestamp_s, frame.id});
    if (frames_.size() > kMaxFrames + 1) frames_.pop_back();
  }
  /// The motion of the frame that began, against the last one whose motion is known.
  void add(const Pose& T_current_reference, const Step& step);
  /// The chain of sure steps, each from the frame before, goes on or ends.
  void chain(bool sure) { unbroken_ = sure ? unbroken_ + 1 : 0; }

  /// Steps whose motion is known.
  std::size_t steps() const { return poses_.empty() ? 0 : poses_.size() - 1; }
  std::size_t unbroken() const { return unbroken_; }  ///< length of the chain
  /// True for the frame before the current one.
  bool is_last_frame(std::int64_t id) const { return frames_.size() > 1 && id == frames_[1].id; }
  /// Requires a gap that was passed.
  std::int64_t frame_id(std::size_t gap) const { return frames_[gap].id; }
  /// Over a gap, as if at 30 Hz where stamps do not increase.
  double elapsed_s(std::size_t gap) const {
    const double elapsed = gap < frames_.size() ? frames_[0].stamp_s - frames_[gap].stamp_s : 0;
    return elapsed > 0 ? elapsed : static_cast<double>(gap) * kUnknownStep_s;
  }
  /// From the camera `then` frames back to that of `now` frames back. The current frame counts when added.
  Pose between(std::size_t now, std::size_t then) const { return inverse(poses_[now]) * poses_[then]; }
  /// The motion from frame to frame, over the last few: a mover that sets off slowly drags it away less.
  Pose usual_step() const;
  /// Rate of turn of the last added step, while the current frame is not added.
  Eigen::Vector3d last_turn_radps() const {
    return rotation_vector(between(0, 1).R()) / (elapsed_s(2) - elapsed_s(1));
  }
  /// Noise that neighbours do not share, summed over the steps of a gap.
  double noise_px(std::size_t gap) const {
    double sum2 = 0;
    for (std::size_t k = 0; k < gap && k < steps_.size(); ++k)
      sum2 += steps_[k].match_noise_px * steps_[k].match_noise_px + kLeastNoise_px * kLeastNoise_px;
    return std::sqrt(sum2);
  }
  /// Of the current frame's rows against those of the frame `gap` frames back.
  const RowTwist& twist(std::size_t gap) const { return twist_over_[gap - 1]; }

 private:
  static constexpr double kUnknownStep_s = 1.0 / 30;  ///< where stamps do not increase
  static constexpr double kLeastNoise_px = 0.05;      ///< flow is not more exact
  static constexpr std::size_t kUsualSteps = 4;

  struct Frame {
    double stamp_s;
    std::int64_t id;
  };

  std::vector<Frame> frames_;  ///< newest first, as all here
  std::vector<Pose> poses_;    ///< T_world_camera
  std::vector<Step> steps_;
  std::vector<RowTwist> twist_over_;  ///< [g - 1]: summed over g steps
  std::size_t unbroken_ = 0;
};

inline void CameraPath::add(const Pose& T_current_reference, const Step& step) {
  if (poses_.empty()) poses_.push_back(Pose());
  const Pose T = poses_.front() * inverse(T_current_reference);
  // Made a rotation again in every step: otherwise rounding grows with the chain.
  const Eigen::Matrix3d R = Eigen::Quaterniond(T.R()).normalized().toRotationMatrix();
  poses_.insert(poses_.begin(), Pose::from(R, T.t()));
  steps_.insert(steps_.begin(), step);
  // As many as lie within the window, two at least.
  std::size_t keep = 2;
  while (keep < steps() && keep < kMaxFrames && elapsed_s(keep + 1) < kWindow_s + kUnknownStep_s / 2) ++keep;
  if (poses_.size() > keep + 1) poses_.resize(keep + 1);
  if (steps_.size() > keep) steps_.resize(keep);
  twist_over_.clear();
  RowTwist sum;
  for (const Step& s : steps_) {
    sum.a_rad += s.twist.a_rad;
    twist_over_.push_back(sum);
  }
}

inline Pose CameraPath::usual_step() const {
  const std::size_t frames = std::min(kUsualSteps, steps());
  const auto share = 1 / static_cast<double>(frames);
  const Pose over = between(0, frames);
  const Eigen::Vector3d turn = share * rotation_vector(over.R());
  const double angle_rad = turn.norm();
  const Eigen::Matrix3d R =
      angle_rad > 0 ? rotation_about(turn / angle_rad, angle_rad) : Eigen::Matrix3d::Identity();
  return Pose::from(R, share * over.t());
}

}  // namespace dynfilter
