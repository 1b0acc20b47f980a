// SPDX-License-Identifier: MIT
#include "render/camera_path.hpp"

#include <algorithm>

#include "render/skeleton.hpp"

namespace dynfilter::render {

Eigen::Isometry3d look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - eye).normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  return frame_at(eye, rotation);
}

CameraMotion::CameraMotion(const Options& options, Random& random) : options_(options) {
  for (double& phase : phase_) phase = random.uniform(0, 2 * M_PI);
  if (options.style == CameraStyle::Turn) turn_ = HandTurn(options.peak_deg_s * M_PI / 180, random);
  if (options.style == CameraStyle::Shake) shake_ = HandShake(random);
}

Eigen::Isometry3d CameraMotion::pose(double time_s) const {
  switch (options_.style) {
    case CameraStyle::Xyz:
      return xyz(time_s) * tremor(time_s);
    case CameraStyle::Rpy:
      return rpy(time_s) * tremor(time_s);
    case CameraStyle::Halfsphere:
      return halfsphere(time_s) * tremor(time_s);
    case CameraStyle::Sideways:
      return sideways(time_s);
    case CameraStyle::Tracking:
      return tracking(time_s) * tremor(time_s);
    case CameraStyle::Turn:
      return turned(time_s);
    case CameraStyle::Shake:
      return shaken(time_s);
    case CameraStyle::Tripod:
      return look_at(options_.eye_m, options_.target_m);
    case CameraStyle::Driving:
      return driving(time_s);
    case CameraStyle::Flying:
      return flying(time_s);
    case CameraStyle::Static:
      break;
  }
  return look_at(options_.eye_m, options_.target_m) * tremor(time_s);
}

inline Eigen::Isometry3d CameraMotion::tremor(double t) const {
  const auto mixed = [&](int i) {
    return 0.6 * wave(t, 0.93 + 0.07 * i, i) + 0.4 * wave(t, 0.31 + 0.02 * i, i + 1);
  };
  const Eigen::Vector3d turn_rad = 0.0016 * Eigen::Vector3d(mixed(3), mixed(4), mixed(5));
  return frame_at(0.0016 * Eigen::Vector3d(mixed(0), mixed(1), mixed(2)),
                  turn(turn_rad.norm(), turn_rad.normalized()));
}

inline Eigen::Isometry3d CameraMotion::xyz(double t) const {
  const Eigen::Vector3d offset(0.27 * wave(t, 7.3, 0), 0.16 * wave(t, 5.9, 1), 0.13 * wave(t, 4.7, 2));
  const Eigen::Isometry3d base = look_at(options_.eye_m, options_.target_m);
  return frame_at(base.translation() + offset, base.linear() *
                                                   turn(0.025 * wave(t, 3.9, 3), Eigen::Vector3d::UnitY()) *
                                                   turn(0.02 * wave(t, 3.1, 4), Eigen::Vector3d::UnitX()));
}

inline Eigen::Isometry3d CameraMotion::rpy(double t) const {
  const Eigen::Isometry3d base = look_at(options_.eye_m, options_.target_m);
  const Eigen::Matrix3d shake = turn(0.26 * wave(t, 3.1, 0), Eigen::Vector3d::UnitY()) *
                                turn(0.15 * wave(t, 2.4, 1), Eigen::Vector3d::UnitX()) *
                                turn(0.20 * wave(t, 2.9, 2), Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d drift(0.03 * wave(t, 4.1, 3), 0.02 * wave(t, 3.7, 4), 0.02 * wave(t, 3.3, 5));
  return frame_at(base.translation() + drift, base.linear() * shake);
}

inline Eigen::Isometry3d CameraMotion::turned(double t) const {
  const Eigen::Isometry3d base = look_at(options_.eye_m, options_.target_m);
  const Eigen::Vector3d drift(0.04 * wave(t, 2.3, 0), 0.03 * wave(t, 2.9, 1), 0.03 * wave(t, 1.9, 2));
  return frame_at(base.translation() + drift, base.linear() * turn_.rotation(t));
}

inline Eigen::Isometry3d CameraMotion::shaken(double t) const {
  Eigen::Isometry3d base = look_at(options_.eye_m, options_.target_m);
  base.translation() +=
      Eigen::Vector3d(0.12 * wave(t, 5.3, 0), 0.05 * wave(t, 4.3, 1), 0.06 * wave(t, 3.7, 2));
  return base * shake_.pose(t);
}

inline Eigen::Isometry3d CameraMotion::halfsphere(double t) const {
  const Eigen::Vector3d to_eye = options_.eye_m - options_.target_m;
  const double azimuth = std::atan2(to_eye.y(), to_eye.x()) + 0.42 * wave(t, 15.7, 0);
  const double elevation = 0.28 + 0.19 * wave(t, 11.3, 1),
               radius = to_eye.norm() * (0.97 + 0.05 * wave(t, 9.1, 2));
  const Eigen::Vector3d direction(std::cos(azimuth) * std::cos(elevation),
                                  std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
  return look_at(options_.target_m + radius * direction, options_.target_m);
}

inline Eigen::Isometry3d CameraMotion::sideways(double t) const {
  Eigen::Isometry3d pose = look_at(options_.eye_m, options_.target_m);
  pose.translation().x() += 0.5 * wave(t, 7.0, 0);
  return pose;
}

inline Eigen::Isometry3d CameraMotion::tracking(double t) const {
  Eigen::Vector2d smooth(0, 0);
  constexpr int kHalf = 4, kTaps = 2 * kHalf + 1;
  for (int i = -kHalf; i <= kHalf; ++i) smooth += options_.tracked->place(t + 0.15 * i) / kTaps;
  const Eigen::Vector3d person(smooth.x(), smooth.y(), options_.target_m.z());
  Eigen::Vector3d eye = options_.eye_m;
  eye.head<2>() += 0.7 * (smooth - options_.target_m.head<2>());
  return look_at(eye, person);
}

inline Eigen::Isometry3d CameraMotion::driving(double t) const {
  constexpr double kHeight_m = 1.65;  // KITTI's
  const Eigen::Isometry3d car = options_.drive->pose(t);
  // The body of the car heaves, pitches and rolls on its springs.
  const Eigen::Vector3d eye = car * Eigen::Vector3d(0, 0, kHeight_m + 0.012 * wave(t, 0.9, 0));
  const Eigen::Isometry3d level = look_at(eye, eye + car.linear().col(1));
  const double moving =
      std::min(1.0, (options_.drive->pose(t + 0.5).translation() - car.translation()).norm());
  return frame_at(eye, level.linear() * turn(0.004 * moving * wave(t, 1.1, 1), Eigen::Vector3d::UnitX()) *
                           turn(0.003 * moving * wave(t, 1.4, 2), Eigen::Vector3d::UnitZ()));
}

inline Eigen::Isometry3d CameraMotion::flying(double t) const {
  const double height_m = 2.35 + 0.65 * wave(t, 9, 2);  // above the partitions
  const Eigen::Vector3d eye(4.6 * wave(t, 17, 0), 6.4 * wave(t, 21, 1), height_m);
  const double yaw = 0.9 * wave(t, 8.3, 3) + 0.25 * wave(t, 3.1, 4);
  const Eigen::Vector3d ahead(-std::sin(yaw), std::cos(yaw), -0.12);
  return frame_at(eye, look_at(eye, eye + ahead).linear() *
                           turn(0.16 * wave(t, 2.7, 5), Eigen::Vector3d::UnitX()) *
                           turn(0.18 * wave(t, 3.3, 6), Eigen::Vector3d::UnitZ()));
}

}  // namespace dynfilter::render
