// SPDX-License-Identifier: MIT
// Runs of dynfilter.comparison as tables for a paper, with the columns that `dynfilter compare` writes.
#include "comparison.hpp"

#include <pybind11/stl.h>

#include <dynfilter/version.hpp>
#include <running/commit.hpp>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "eval/paper_table.hpp"
#include "eval/signed_rank.hpp"

namespace dynfilter::python {

namespace py = pybind11;

eval::ComparedRun compared_run(py::handle run) {
  const auto figure = [&run](const char* name) { return run.attr(name).cast<double>(); };
  const auto text = [&run](const char* name) { return py::str(run.attr(name)).cast<std::string>(); };
  eval::ComparedRun result;
  result.sequence = text("sequence"), result.variant = text("variant"), result.pipeline = text("pipeline");
  result.scene = text("scene").empty() ? result.sequence : text("scene");
  result.place = result.scene;
  result.alignment = text("alignment");
  result.failed = !text("failure").empty();
  result.has_poses = !run.attr("trajectory").is_none();
  result.frames = run.attr("frames").cast<std::size_t>();
  result.tracked_frames = run.attr("tracked_frames").cast<std::size_t>();
  result.first_s = figure("first_s"), result.last_s = figure("last_s");
  result.ate_rmse_m = figure("ate_rmse_m"), result.rpe_trans_rmse_m = figure("rpe_trans_rmse_m");
  result.recall = figure("recall"), result.static_kept = figure("static_kept");
  result.cpu_ms = figure("cpu_ms");
  return result;
}

eval::Comparison compared(const py::iterable& runs, const std::string& reference) {
  std::vector<eval::ComparedRun> all;
  for (const py::handle run : runs) all.push_back(compared_run(run));
  return eval::compare_runs(all, reference);
}

namespace {

std::string paper_table(const std::string& format, const py::iterable& runs, const std::string& reference) {
  return eval::paper_table(format, compared(runs, reference),
                           {DYNFILTER_VERSION, command::source_commit(), eval::machine_class()});
}

}  // namespace

void bind_comparison(py::module_& module) {
  module.def("_paper_table", &paper_table, py::arg("format"), py::arg("runs"), py::arg("reference"));
  module.def(
      "_signed_rank_p",
      [](const std::vector<double>& differences) { return eval::signed_rank_test(differences).p; },
      py::arg("differences"));
}

}  // namespace dynfilter::python
