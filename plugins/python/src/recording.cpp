// SPDX-License-Identifier: MIT
// The report that `dynfilter compare --out` writes, of runs in Python.
#ifdef DYNFILTER_PYTHON_ODOMETRY

#include "recording.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <report/page.hpp>
#include <running/compared_run.hpp>
#include <utility>
#include <vector>

#include "comparison.hpp"

namespace dynfilter::python {

namespace report = command::report;

Recording::Recording(const command::PipelineJudge& judge, std::size_t frames, std::size_t runs)
    : Recording(judge, frames, report::RunShare(runs)) {}

Recording::Recording(const command::PipelineJudge& judge, std::size_t frames, const report::RunShare& share)
    : recorder_(judge.totals(), frames, share.pictures, share.picture_bytes, 0, 1, share.rows) {}

void Recording::add(command::FrameRow row, const command::PipelineJudge& judge, const cv::Mat& truth,
                    command::OverlayFrame picture) {
  if (!truth.empty()) row.truth = command::judged(judge.record(), truth);
  statistics_.add(row);
  if (recorder_.wants_picture()) {
    picture.features = judge.record().features, picture.stages = judge.stages();
    const int width_px = recorder_.picture_width_px();
    recorder_.add_picture(width_px > 0 ? command::Overlay(width_px).draw_bare(picture)
                                       : command::Overlay().draw(picture));
  }
  recorder_.add(row, judge, NAN);
}

report::RunRecord Recording::finish(pybind11::handle run, const command::PipelineJudge& judge,
                                    const io::Trajectory& estimate,
                                    const std::optional<io::Trajectory>& truth, const std::string& sensor,
                                    bool verdicts_only) {
  command::Summary summary;
  if (statistics_.frames() > 0) statistics_.summarise(summary);
  summary.stages = judge.totals(), summary.sensor = sensor, summary.verdicts_only = verdicts_only;
  summary.ate_rmse_m = run.attr("ate_rmse_m").cast<double>();  // without it there is no error per frame
  report::RunRecord record = recorder_.finish(truth, estimate, summary, nullptr);
  name_record(run, record);
  return record;
}

void name_record(pybind11::handle run, report::RunRecord& record) {
  const eval::ComparedRun compared = compared_run(run);
  command::Summary& s = record.summary;
  s.sequence = compared.sequence, s.scene = compared.scene, s.pipeline = compared.pipeline;
  record.variant = compared.variant;
  s.tracked_frames = compared.tracked_frames;
  s.ate_rmse_m = compared.ate_rmse_m, s.rpe_trans_rmse_m = compared.rpe_trans_rmse_m;
  s.rpe_rot_rmse_deg = run.attr("rpe_rot_rmse_deg").cast<double>();
  s.precision = run.attr("precision").cast<double>();
  s.recall = compared.recall, s.static_kept = compared.static_kept;
  s.failure = run.attr("failure").cast<std::string>();
  s.notes = run.attr("notes").cast<std::vector<std::string>>();
}

void bind_recording(pybind11::module_& module) {
  pybind11::class_<report::RunRecord>(module, "_RunRecord");
  module.def(
      "_compare_page",
      [](const pybind11::list& runs, const std::string& reference) {
        std::vector<report::RunRecord> records;
        for (const pybind11::handle run : runs) {
          records.push_back(run.attr("_record").cast<report::RunRecord>());
          name_record(run, records.back());
        }
        return report::compare_page(records, command::medians_json(compared(runs, reference)));
      },
      pybind11::arg("runs"), pybind11::arg("reference"));
}

}  // namespace dynfilter::python

#endif
