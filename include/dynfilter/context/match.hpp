// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <dynfilter/context/history.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Which earlier frame the current one is held against.
struct Reference {
  bool keyframe = false;  ///< the last keyframe; else:
  int gap_frames = 1;     ///< so many frames back, or the oldest frame that is kept
};

/// Where the current features were in a reference frame, and what that frame knew of these places. One entry
/// per current feature; NaN where there is none.
struct Match {
  bool valid = false;                      ///< belongs to the current frame (bookkeeping of Context)
  const StoredFrame* reference = nullptr;  ///< null: there is no such frame
  Correspondences correspondences;
  std::vector<cv::Point2f> reference_undistorted_px;
  std::vector<float> reference_depth_m;
  std::vector<cv::Point3f> reference_points_m;  ///< in the reference camera's frame

  bool found(std::size_t i) const { return correspondences.found[i] != 0; }
  bool has_depth(std::size_t i) const { return std::isfinite(reference_points_m[i].z); }
};

}  // namespace dynfilter
