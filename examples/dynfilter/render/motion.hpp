// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "render/skeleton.hpp"
#include "render/walk_path.hpp"

namespace dynfilter::render {

/// Poses of the rigid parts of a mover at any time, including before the first frame.
class Animation {
 public:
  virtual ~Animation() = default;
  /// Poses of the parts in the world, one per part of the mover's body.
  virtual void pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const = 0;
};

constexpr double kAlways = -1e9;

/// Equivalent time at full speed [s]. Static until `start_s`, then accelerates within 0.4 s.
double moving_time(double time_s, double start_s);

/// 0 before the start, 1 at full speed.
double started(double time_s, double start_s);

/// Centre of a box carried in both hands, in the frame of the chest.
inline Eigen::Vector3d carried_box_centre(const BodyShape& shape) {
  return {0, 0.36 * shape.scale, 0.12 * shape.scale};
}

/// Walks along a closed path.
/// During stance, a foot remains on its print on the floor and rolls from heel to toe.
/// Arms swing opposite to the legs, or hold a box.
class Walking : public Animation {
 public:
  struct Options {
    double speed_mps = 1.1;
    double offset_m = 0;  ///< position on the path at time 0
    double start_s = kAlways;
    bool carries_box = false;
    double glance_rad = 0.3;  ///< amplitude of the slow rotation of the head
  };

  Walking(const BodyShape& shape, WalkPath path, const Options& options)
      : shape_(shape),
        path_(std::move(path)),
        options_(options),
        stride_m_((0.62 + 0.58 * options.speed_mps) * shape.scale) {}

  double travelled_m(double time_s) const {
    return options_.offset_m + options_.speed_mps * moving_time(time_s, options_.start_s);
  }
  Eigen::Vector2d place(double time_s) const { return path_.at(travelled_m(time_s)); }

  void pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const override;

 private:
  // Half of the share of a stride with the foot on the floor.
  static constexpr double kStance = 0.31;

  struct Foot {
    Eigen::Vector3d ball;
    Eigen::Vector2d heading;
    double pitch_rad;  // toe up is positive
  };

  Foot print(double s_m, double sign) const;

  /// `phase`: strides since this foot was below the body in the middle of its stance.
  Foot foot(double s_m, double sign, double shift) const;

  static double stance_pitch(double t);

  BodyTargets targets(double time_s) const;

  void legs(double s, double going, const Eigen::Matrix3d& facing, BodyTargets& to) const;

  void arms(double phase, double going, BodyTargets& to) const;

  BodyShape shape_;
  WalkPath path_;
  Options options_;
  double stride_m_;
};

/// A person who sits or stands at one place and gestures.
class Gesturing : public Animation {
 public:
  struct Options {
    Eigen::Vector2d place{0, 0};
    double yaw_rad = 0;  ///< 0 looks north (+y)
    bool sits = true;
    double start_s = kAlways;
    double liveliness = 1;  ///< amplitude of the gestures; 0: static
    double tempo = 1;
    double offset_s = 0;
  };

  Gesturing(const BodyShape& shape, const Options& options) : shape_(shape), options_(options) {}

  void pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const override;

 private:
  BodyTargets targets(double time_s) const;

  void legs(const Eigen::Matrix3d& facing, BodyTargets& to) const;

  void hands(double t, double k, double life, BodyTargets& to) const;

  BodyShape shape_;
  Options options_;
};

/// A rigid object, such as a cart with boxes, that rolls along a path.
class Rolling : public Animation {
 public:
  Rolling(WalkPath path, double speed_mps, double offset_m, double start_s)
      : path_(std::move(path)), speed_mps_(speed_mps), offset_m_(offset_m), start_s_(start_s) {}

  void pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const override;

 private:
  WalkPath path_;
  double speed_mps_, offset_m_, start_s_;
};

/// A rigid object that slides along a straight line, following a sine.
class Sliding : public Animation {
 public:
  struct Options {
    Eigen::Vector3d middle{0, 0, 0}, swing_m{0.5, 0, 0};
    double period_s = 4, offset_s = 0, start_s = kAlways, yaw_rad = 0;
  };
  explicit Sliding(const Options& options) : options_(options) {}

  void pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const override;

 private:
  Options options_;
};

}  // namespace dynfilter::render
