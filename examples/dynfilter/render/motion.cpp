// SPDX-License-Identifier: MIT
#include "render/motion.hpp"

#include <algorithm>
#include <cmath>

namespace dynfilter::render {

double moving_time(double time_s, double start_s) {
  constexpr double kRamp = 0.4;
  if (start_s == kAlways) return time_s;
  const double t = time_s - start_s;
  if (t <= 0) return 0;
  return t < kRamp ? t * t / (2 * kRamp) : t - kRamp / 2;
}

double started(double time_s, double start_s) {
  if (start_s == kAlways) return 1;
  const double t = std::min(1.0, std::max(0.0, (time_s - start_s) / 0.4));
  return t * t * (3 - 2 * t);
}

void Walking::pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const {
  const BodyPose body = solve_pose(shape_, targets(time_s));
  parts.assign(body.begin(), body.end());
  if (options_.carries_box) {
    parts.push_back(body[kChest] * frame_at(carried_box_centre(shape_), Eigen::Matrix3d::Identity()));
  }
}

inline Walking::Foot Walking::print(double s_m, double sign) const {
  const Eigen::Vector2d h = path_.heading(s_m), right(h.y(), -h.x());
  const Eigen::Vector2d p = path_.at(s_m) + sign * 0.085 * shape_.scale * right + 0.08 * shape_.scale * h;
  return {{p.x(), p.y(), 0}, h, 0};
}

inline Walking::Foot Walking::foot(double s_m, double sign, double shift) const {
  const double phase = s_m / stride_m_ - shift;
  const double step = std::round(phase), t = phase - step;
  Foot now = print((step + shift) * stride_m_, sign);
  if (std::abs(t) <= kStance) {
    now.pitch_rad = stance_pitch(t);
    return now;
  }
  const double swing = t > 0 ? (t - kStance) / (1 - 2 * kStance) : (t + 1 - kStance) / (1 - 2 * kStance);
  const double from = t > 0 ? step : step - 1;
  const Foot a = print((from + shift) * stride_m_, sign), b = print((from + 1 + shift) * stride_m_, sign);
  const double ease = swing * swing * (3 - 2 * swing);
  Foot out{a.ball + ease * (b.ball - a.ball), (a.heading + ease * (b.heading - a.heading)).normalized(), 0};
  out.ball.z() = 0.07 * shape_.scale * std::sin(M_PI * swing);
  out.pitch_rad = (1 - ease) * stance_pitch(kStance) + ease * stance_pitch(-kStance);
  return out;
}

inline double Walking::stance_pitch(double t) {
  if (t < -0.2) return 0.28 * (-0.2 - t) / (kStance - 0.2);
  if (t > 0.08) return -0.75 * (t - 0.08) / (kStance - 0.08);
  return 0;
}

inline BodyTargets Walking::targets(double time_s) const {
  const double s = travelled_m(time_s), going = started(time_s, options_.start_s), k = shape_.scale;
  const double phase = 2 * M_PI * s / stride_m_;
  const Eigen::Vector2d h = path_.heading(s);
  const Eigen::Matrix3d facing = turn(std::atan2(-h.x(), h.y()), Eigen::Vector3d::UnitZ());
  BodyTargets to;
  const double bob = going * (-0.035 + 0.018 * std::cos(2 * phase)) * k,
               sway = going * 0.018 * k * std::cos(phase);
  const Eigen::Vector2d p = path_.at(s);
  const Eigen::Matrix3d hips = facing * turn(going * 0.09 * std::sin(phase), Eigen::Vector3d::UnitZ());
  to.pelvis = frame_at(
      Eigen::Vector3d(p.x(), p.y(), shape_.hip_height() - 0.01 * k + bob) - facing.col(0) * sway, hips);
  to.chest_in_pelvis = turn(-going * 0.2 * std::sin(phase), Eigen::Vector3d::UnitZ()) *
                       turn(options_.carries_box ? 0.06 : -0.05 * going, Eigen::Vector3d::UnitX());
  to.head_in_chest = turn(going * options_.glance_rad * std::sin(0.9 * time_s + options_.offset_m),
                          Eigen::Vector3d::UnitZ());
  legs(s, going, facing, to);
  arms(phase, going, to);
  return to;
}

inline void Walking::legs(double s, double going, const Eigen::Matrix3d& facing, BodyTargets& to) const {
  const double k = shape_.scale;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1;
    Foot step = foot(s, sign, side == 0 ? 0.0 : 0.5);
    const Foot rest = print(s, sign);
    step.ball = rest.ball + going * (step.ball - rest.ball);
    step.heading = (rest.heading + going * (step.heading - rest.heading)).normalized();
    step.pitch_rad *= going;
    const Eigen::Matrix3d yaw =
        turn(std::atan2(-step.heading.x(), step.heading.y()), Eigen::Vector3d::UnitZ());
    to.foot[side] = yaw * turn(step.pitch_rad, Eigen::Vector3d::UnitX());
    // Rolls over the heel (toe up) or the ball of the foot (heel up).
    const Eigen::Vector3d pivot(0, (step.pitch_rad > 0 ? -0.06 : 0.13) * k, -shape_.ankle_height());
    const Eigen::Vector3d flat = step.ball + yaw * Eigen::Vector3d(0, -0.08 * k, shape_.ankle_height());
    to.ankle[side] = flat + yaw * pivot - to.foot[side] * pivot;
    to.knee_bend[side] = (facing + yaw).col(1);
  }
}

inline void Walking::arms(double phase, double going, BodyTargets& to) const {
  const Eigen::Isometry3d chest = to.pelvis * frame_at({0, 0, shape_.waist()}, to.chest_in_pelvis);
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1;
    // Left arm forward when the right leg is.
    const double swing = -going * 0.48 * std::sin(phase) * sign;
    const Eigen::Vector3d shoulder(sign * shape_.shoulder_half(), 0, shape_.shoulder_up());
    const Eigen::Matrix3d arm =
        turn(sign * -0.12, Eigen::Vector3d::UnitY()) * turn(swing, Eigen::Vector3d::UnitX());
    const Eigen::Vector3d elbow = shoulder + arm * Eigen::Vector3d(0, 0, -shape_.upper_arm());
    const Eigen::Matrix3d bent =
        arm * turn(0.25 + going * (0.25 + 0.35 * std::max(0.0, swing)), Eigen::Vector3d::UnitX());
    Eigen::Vector3d wrist = elbow + bent * Eigen::Vector3d(0, 0, -shape_.forearm());
    Eigen::Vector3d bend = arm * Eigen::Vector3d(0, -1, 0);
    if (options_.carries_box) {
      wrist = carried_box_centre(shape_) + shape_.scale * Eigen::Vector3d(sign * 0.21, -0.06, -0.03);
      bend = {sign * 0.8, -0.6, -0.4};
    }
    to.wrist[side] = chest * wrist;
    to.elbow_bend[side] = chest.linear() * bend;
  }
}

void Gesturing::pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const {
  const BodyPose body = solve_pose(shape_, targets(time_s));
  parts.assign(body.begin(), body.end());
}

inline BodyTargets Gesturing::targets(double time_s) const {
  const double t = options_.tempo * (moving_time(time_s, options_.start_s) + options_.offset_s),
               k = shape_.scale;
  const double life = options_.liveliness;
  const Eigen::Matrix3d facing = turn(options_.yaw_rad, Eigen::Vector3d::UnitZ());
  const double hips = options_.sits ? 0.54 : shape_.hip_height() - 0.012;
  BodyTargets to;
  to.pelvis = frame_at({options_.place.x(), options_.place.y(), hips},
                       facing * turn(0.05 * life * std::sin(0.7 * t), Eigen::Vector3d::UnitZ()));
  to.chest_in_pelvis = turn(0.22 * life * std::sin(1.7 * t), Eigen::Vector3d::UnitZ()) *
                       turn(-0.08 + 0.11 * life * std::sin(1.5 * t + 1), Eigen::Vector3d::UnitX());
  to.head_in_chest = turn(0.45 * life * std::sin(1.3 * t + 2), Eigen::Vector3d::UnitZ()) *
                     turn(0.12 * life * std::sin(2.1 * t), Eigen::Vector3d::UnitX());
  legs(facing, to);
  hands(t, k, life, to);
  return to;
}

inline void Gesturing::legs(const Eigen::Matrix3d& facing, BodyTargets& to) const {
  const double k = shape_.scale;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1;
    const Eigen::Vector3d at(options_.place.x(), options_.place.y(), shape_.ankle_height());
    to.ankle[side] = at + facing * Eigen::Vector3d(sign * 0.12 * k, options_.sits ? 0.42 * k : -0.01, 0);
    to.foot[side] = facing * turn(-sign * 0.15, Eigen::Vector3d::UnitZ());
    to.knee_bend[side] = facing * Eigen::Vector3d(sign * 0.15, 1, options_.sits ? 0.6 : 0);
  }
}

inline void Gesturing::hands(double t, double k, double life, BodyTargets& to) const {
  const Eigen::Isometry3d chest = to.pelvis * frame_at({0, 0, shape_.waist()}, to.chest_in_pelvis);
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1, shift = side == 0 ? 0 : 1.9;
    const Eigen::Vector3d rest(sign * 0.2, 0.34, 0.1);
    const Eigen::Vector3d wave(0.12 * std::sin(3.1 * t + shift), 0.07 * std::sin(2.3 * t + 2 * shift),
                               0.14 * std::sin(3.7 * t + shift + 0.5));
    to.wrist[side] = chest * (k * (rest + life * wave));
    to.elbow_bend[side] = chest.linear() * Eigen::Vector3d(sign * 0.7, -0.5, -0.9);
  }
}

void Rolling::pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const {
  const double s = offset_m_ + speed_mps_ * moving_time(time_s, start_s_);
  const Eigen::Vector2d p = path_.at(s), h = path_.heading(s);
  parts.assign(1, frame_at({p.x(), p.y(), 0}, turn(std::atan2(-h.x(), h.y()), Eigen::Vector3d::UnitZ())));
}

void Sliding::pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const {
  const double t = moving_time(time_s, options_.start_s) + options_.offset_s;
  const Eigen::Vector3d at = options_.middle + std::sin(2 * M_PI * t / options_.period_s) * options_.swing_m;
  parts.assign(1, frame_at(at, turn(options_.yaw_rad, Eigen::Vector3d::UnitZ())));
}

}  // namespace dynfilter::render
