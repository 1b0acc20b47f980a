// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <report/recorder.hpp>
#include <running/frame_row.hpp>
#include <string>

#include "io/trajectory.hpp"

namespace dynfilter::python {

/// Collects what a report shows of a run of the odometry.
class Recording {
 public:
  /// `runs`: of the report, which share its pictures.
  Recording(const command::PipelineJudge& judge, std::size_t frames, std::size_t runs);

  /// The frame that the judge has seen last. Its truth may be empty.
  void add(command::FrameRow row, const command::PipelineJudge& judge, const cv::Mat& truth,
           command::OverlayFrame picture);

  /// `run`: the dynfilter.Run, for its figures.
  command::report::RunRecord finish(pybind11::handle run, const command::PipelineJudge& judge,
                                    const io::Trajectory& estimate,
                                    const std::optional<io::Trajectory>& truth, const std::string& sensor,
                                    bool verdicts_only);

 private:
  Recording(const command::PipelineJudge& judge, std::size_t frames, const command::report::RunShare& share);

  command::report::RunRecorder recorder_;
  command::FrameStatistics statistics_;
};

/// Puts the figures and names of a dynfilter.Run into its record: compare() may have changed its names.
void name_record(pybind11::handle run, command::report::RunRecord& record);

void bind_recording(pybind11::module_& module);

}  // namespace dynfilter::python
