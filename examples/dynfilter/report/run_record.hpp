// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/map_frame.hpp>
#include <string>
#include <vector>

#include "io/trajectory.hpp"
#include "running/run_summary.hpp"

namespace dynfilter::command::report {

/// Time of one stage in each played frame [ms]; NaN where it was not reached.
struct StageSeries {
  std::string call_point, name, path;
  int depth = 0;  ///< below the call point's first stage
  std::vector<double> ms;
};

/// Features rejected for one reason ("semantic_box+epipolar") in each played frame.
struct ReasonSeries {
  std::string name;
  std::vector<std::size_t> features;
};

/// Why a frame deserves a look.
struct FrameMark {
  std::size_t frame = 0;  ///< position in RunRecord::rows
  std::string kind;       ///< floor, late, lost, uncertain or failed
  std::string text;
};

struct FramePicture {
  std::size_t frame = 0;  ///< position in RunRecord::rows
  std::vector<std::uint8_t> jpeg;
};

/// What a report shows of one run.
struct RunRecord {
  Summary summary;
  std::string variant;  ///< "reverse from 5"; "" for a whole sequence
  std::vector<FrameRow> rows;
  std::vector<double> age_frames;     ///< of boxes or masks, per row; NaN: there were none
  std::vector<std::size_t> restored;  ///< kept by the floor in the end, per row
  std::vector<ReasonSeries> reasons;
  std::vector<StageSeries> stages;
  std::vector<FrameMark> marks;
  std::vector<FramePicture> pictures;

  // In the frame of the ground truth, if there is any, else in that of the first camera.
  std::vector<Eigen::Vector3d> positions_m;  ///< per row; NaN where not tracked
  std::vector<double> errors_m;              ///< per row, as in the ATE; NaN without truth
  std::vector<Eigen::Vector3d> truth_m;      ///< thinned
  std::vector<double> truth_s;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();  ///< mean of the cameras' upward directions

  std::vector<Eigen::Vector3f> map_m;  ///< thinned
  std::vector<cv::Vec3b> map_bgr;
  std::size_t map_points = 0;  ///< before thinning
  Eigen::Vector3d map_up = Eigen::Vector3d::Zero();
};

}  // namespace dynfilter::command::report
