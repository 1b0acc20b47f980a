// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

namespace dynfilter {
class OrbSlam;
}

namespace ORB_SLAM2 {

/// The host's class with the lines of docs/tutorials/orb_slam_fork.md.
class Tracking {
 public:
  explicit Tracking(const std::string& settings_file);
  /// Summary of one frame of noise.
  std::string grab(unsigned number);
  /// What a program of the host asks its library.
  static int stages_of(const dynfilter::OrbSlam& filter);

  std::shared_ptr<dynfilter::OrbSlam> mpDynFilter;
};

}  // namespace ORB_SLAM2
