// SPDX-License-Identifier: MIT
// Trajectories and their errors. A trajectory is a pair of arrays: (n,) stamps [s] and (n, 4, 4)
// T_world_camera.
#include <pybind11/stl.h>

#include <algorithm>
#include <string>

#include "arguments.hpp"
#include "bindings.hpp"
#include "eval/ate.hpp"
#include "eval/rpe.hpp"
#include "io/trajectory.hpp"
#include "io/trajectory_formats.hpp"
#include "trajectory.hpp"

namespace dynfilter::python {

py::tuple arrays_of(const io::Trajectory& trajectory) {
  const auto n = static_cast<py::ssize_t>(trajectory.size());
  py::array_t<double> stamps(n), poses({n, py::ssize_t{4}, py::ssize_t{4}});
  std::fill_n(poses.mutable_data(), 16 * n, 0.0);
  for (py::ssize_t i = 0; i < n; ++i) {
    const io::StampedPose& pose = trajectory[static_cast<std::size_t>(i)];
    stamps.mutable_data()[i] = pose.timestamp_s;
    const py::array_t<double> matrix = matrix_of(pose.T_world_camera);
    std::copy_n(matrix.data(), 16, poses.mutable_data() + 16 * i);
  }
  return py::make_tuple(stamps, poses);
}

io::Trajectory trajectory_of(const std::string& argument, py::handle value) {
  if (!py::isinstance<py::sequence>(value) || py::len(value) != 2)
    refuse(argument, "(timestamps, poses)", value);
  const auto stamps = array_of<double>(argument + " timestamps", value[py::int_(0)], -1);
  const py::ssize_t n = stamps.size();
  const py::object poses = py::reinterpret_borrow<py::object>(value[py::int_(1)]);
  const auto all = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(poses);
  if (!all || all.ndim() != 3 || all.shape(0) != n || all.shape(1) != 4 || all.shape(2) != 4) {
    PyErr_Clear();
    refuse(argument + " poses", "numbers of shape (" + std::to_string(n) + ", 4, 4)", poses);
  }
  io::Trajectory trajectory;
  for (py::ssize_t i = 0; i < n; ++i)
    trajectory.push_back({stamps.at(i), pose_of(argument, poses[py::int_(i)])});
  return io::sorted_by_time(std::move(trajectory));
}

namespace {

py::tuple read_trajectory(const std::string& path) {
  return arrays_of(io::read_trajectory(path).trajectory);
}

void write_trajectory(const std::string& path, py::handle trajectory) {
  io::write_tum_trajectory(path, trajectory_of("trajectory", trajectory));
}

eval::AteResult ate(py::handle truth, py::handle estimate, bool scale, double max_gap_s) {
  return eval::absolute_trajectory_error(trajectory_of("truth", truth), trajectory_of("estimate", estimate),
                                         {max_gap_s, scale});
}

eval::RpeResult rpe(py::handle truth, py::handle estimate, double delta_s) {
  return eval::relative_pose_error(trajectory_of("truth", truth), trajectory_of("estimate", estimate),
                                   delta_s);
}

py::array similarity(const eval::AteResult& result) {
  const eval::Similarity& s = result.T_truth_estimate;
  const py::array matrix = matrix_of(Pose::from(s.R, s.t));
  py::array_t<double> scaled = matrix;
  for (py::ssize_t row = 0; row < 3; ++row)
    for (py::ssize_t column = 0; column < 3; ++column) scaled.mutable_at(row, column) *= s.scale;
  return std::move(scaled);
}

}  // namespace

void bind_evaluation(py::module_& module) {
  using eval::ErrorStatistics;
  py::class_<ErrorStatistics>(module, "Statistics", "Statistics of a list of errors. `std` divides by n.")
      .def_readonly("rmse", &ErrorStatistics::rmse)
      .def_readonly("mean", &ErrorStatistics::mean)
      .def_readonly("median", &ErrorStatistics::median)
      .def_readonly("std", &ErrorStatistics::std)
      .def_readonly("min", &ErrorStatistics::min)
      .def_readonly("max", &ErrorStatistics::max);
  py::class_<eval::AteResult>(module, "Ate",
                              "Absolute trajectory error [m], as evaluate_ate.py of the TUM tools.")
      .def_readonly("pairs", &eval::AteResult::pairs)
      .def_readonly("error_m", &eval::AteResult::error_m)
      .def_property_readonly("rmse_m", [](const eval::AteResult& r) { return r.error_m.rmse; })
      .def_property_readonly(
          "timestamps", [](const eval::AteResult& r) { return copy_of(r.timestamps_s); },
          "(pairs,) [s], of the truth")
      .def_property_readonly(
          "errors_m", [](const eval::AteResult& r) { return copy_of(r.errors_m); },
          "(pairs,) distance after alignment [m]")
      .def_property_readonly("T_truth_estimate", &similarity, "(4, 4), the alignment, with its scale")
      .def_property_readonly("scale", [](const eval::AteResult& r) { return r.T_truth_estimate.scale; })
      .def("__repr__", [](const eval::AteResult& r) {
        return py::str("Ate(rmse_m={:.4f}, pairs={})").format(r.error_m.rmse, r.pairs);
      });
  py::class_<eval::RpeResult>(module, "Rpe", "Relative pose error, as evaluate_rpe.py of the TUM tools.")
      .def_readonly("pairs", &eval::RpeResult::pairs)
      .def_readonly("translation_m", &eval::RpeResult::translation_m)
      .def_readonly("rotation_deg", &eval::RpeResult::rotation_deg)
      .def("__repr__", [](const eval::RpeResult& r) {
        return py::str("Rpe(translation_m.rmse={:.4f}, rotation_deg.rmse={:.3f}, pairs={})")
            .format(r.translation_m.rmse, r.rotation_deg.rmse, r.pairs);
      });
  module.def("ate", &ate, py::arg("truth"), py::arg("estimate"), py::kw_only(), py::arg("scale") = false,
             py::arg("max_gap_s") = 0.02,
             "Absolute trajectory error. Trajectories are (timestamps (n,) [s], poses (n, 4, 4)).\n"
             "`scale`: Sim(3) instead of SE(3). Raises Error if fewer than three timestamps match.");
  module.def("rpe", &rpe, py::arg("truth"), py::arg("estimate"), py::kw_only(), py::arg("delta_s") = 1.0,
             "Relative pose error over pairs this far apart. Trajectories as for ate().");
  module.def("read_trajectory", &read_trajectory, py::arg("path"),
             "A trajectory file of TUM, KITTI or EuRoC: (timestamps (n,) [s], poses (n, 4, 4)).");
  module.def("write_trajectory", &write_trajectory, py::arg("path"), py::arg("trajectory"),
             "Writes the TUM format.");
}

}  // namespace dynfilter::python
