// SPDX-License-Identifier: MIT
// MotionPrior and Gyroscope: what sensors beside the camera tell of its motion.
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/inertial/gyroscope.hpp>
#include <memory>
#include <optional>
#include <string>

#include "arguments.hpp"
#include "bindings.hpp"
#include "io/gyro_reader.hpp"

namespace dynfilter::python {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Matrix3d rotation_of(const std::string& argument, py::handle value) {
  const auto given = array_of<double>(argument, value, 3, 3);
  Eigen::Matrix3d R = Eigen::Map<const RowMajor3>(given.data());
  if (!is_rigid(Pose::from(R, Eigen::Vector3d::Zero())))
    throw py::value_error(argument + ": expected a rotation, got another 3x3 matrix");
  return R;
}

py::array_t<double> numbers_of(const Eigen::Matrix3d& matrix) {
  const RowMajor3 rows = matrix;
  return py::array_t<double>({3, 3}, rows.data());
}

py::array_t<double> numbers_of(const Eigen::Vector3d& vector) {
  return py::array_t<double>(3, vector.data());
}

MotionPrior make_prior(py::handle rotation, py::handle covariance, py::handle translation,
                       py::handle frame_id) {
  MotionPrior prior;
  prior.reference_frame_id = integer_of("frame_id", frame_id);
  prior.has_translation = !translation.is_none();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  if (prior.has_translation) {
    t = Eigen::Map<const Eigen::Vector3d>(array_of<double>("translation", translation, 3).data());
    if (!t.allFinite()) throw py::value_error("translation: expected finite numbers, got NaN or infinity");
  }
  prior.T_current_reference = Pose::from(rotation_of("rotation", rotation), t);
  const py::ssize_t n = prior.has_translation ? 6 : 3;
  const auto given = array_of<double>("covariance", covariance, n, n);
  for (py::ssize_t row = 0; row < n; ++row)
    std::copy_n(given.data() + n * row, n, prior.covariance.data() + 6 * (6 - n + row) + 6 - n);
  const bool finite = std::all_of(given.data(), given.data() + given.size(),
                                  [](double entry) { return std::isfinite(entry); });
  if (!finite || !prior.valid())
    throw py::value_error("covariance: expected finite numbers, those of the diagonal above 0");
  return prior;
}

py::object translation_of(const MotionPrior& prior) {
  return prior.has_translation ? py::object(numbers_of(prior.T_current_reference.t()))
                               : py::object(py::none());
}

py::array_t<double> covariance_of(const MotionPrior& prior) {
  if (prior.has_translation) return py::array_t<double>({6, 6}, prior.covariance.data());
  return numbers_of(Eigen::Matrix3d(prior.covariance_matrix().bottomRightCorner<3, 3>()));
}

std::unique_ptr<Gyroscope> make_gyroscope(py::handle R_camera_body, py::handle noise_density,
                                          py::handle bias_walk, py::handle first_bias, py::handle kept_s) {
  Gyroscope::Options options;
  if (!R_camera_body.is_none()) options.R_camera_body = rotation_of("R_camera_body", R_camera_body);
  options.noise = {positive_of("noise_density", noise_density), positive_of("bias_walk", bias_walk),
                   positive_of("first_bias", first_bias)};
  options.kept_s = number_of("kept_s", kept_s);
  if (!(options.kept_s > 0))
    throw py::value_error("kept_s: expected a number above 0, got " + number_text(options.kept_s));
  return std::make_unique<Gyroscope>(options);
}

void add_samples(Gyroscope& self, py::handle timestamp, py::handle omega) {
  const py::array any = any_array("timestamp", timestamp);
  if (!any || any.ndim() == 0) {
    const double stamp_s = number_of("timestamp", timestamp);
    self.add({stamp_s, Eigen::Map<const Eigen::Vector3d>(array_of<double>("omega", omega, 3).data())});
    return;
  }
  const auto stamps = array_of<double>("timestamp", any, -1);
  const auto omegas = array_of<double>("omega", omega, stamps.size(), 3);
  for (py::ssize_t i = 0; i < stamps.size(); ++i)
    self.add({stamps.data()[i], Eigen::Map<const Eigen::Vector3d>(omegas.data() + 3 * i)});
}

py::tuple read_samples(const std::string& path) {
  const GyroRecording recording = io::read_gyroscope(path);
  const auto n = static_cast<py::ssize_t>(recording.samples.size());
  py::array_t<double> stamps(n), omegas({n, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < n; ++i) {
    const GyroSample& sample = recording.samples[static_cast<std::size_t>(i)];
    stamps.mutable_data()[i] = sample.timestamp_s;
    std::copy_n(sample.omega_radps.data(), 3, omegas.mutable_data() + 3 * i);
  }
  return py::make_tuple(stamps, omegas, numbers_of(recording.R_camera_body));
}

void bind_prior(py::module_& module) {
  py::class_<MotionPrior>(module, "MotionPrior",
                          "What a gyroscope, wheels or a filter's prediction tell of the camera's motion "
                          "since an earlier frame.\n"
                          "It is weighed against the images, and ignored while it contradicts them.")
      .def(py::init(&make_prior), py::arg("rotation"), py::arg("covariance"),
           py::arg("translation") = py::none(), py::arg("frame_id") = -1,
           "`rotation`: (3, 3) R_current_reference.\n"
           "`covariance`: of a left perturbation. (3, 3) [rad^2] for a rotation alone, else (6, 6) in the\n"
           "order translation [m], rotation [rad].\n"
           "`translation`: (3,) of T_current_reference [m]; None: only the rotation is known.\n"
           "`frame_id`: the frame that the motion begins at; -1: the one before.\n"
           "Raises ValueError unless the motion is rigid, and all variances are above 0.")
      .def_property_readonly(
          "rotation", [](const MotionPrior& p) { return numbers_of(p.T_current_reference.R()); },
          "(3, 3) float64, R_current_reference")
      .def_property_readonly("translation", &translation_of, "(3,) float64 [m], or None")
      .def_property_readonly("covariance", &covariance_of,
                             "(3, 3) float64 of the rotation, or (6, 6) of translation and rotation")
      .def_readonly("frame_id", &MotionPrior::reference_frame_id,
                    "frame that the motion begins at; -1: the one before");
}

}  // namespace

std::optional<MotionPrior> motion_prior_of(const std::string& argument, py::handle value) {
  if (value.is_none()) return std::nullopt;
  if (!py::isinstance<MotionPrior>(value)) refuse(argument, "a dynfilter.MotionPrior", value);
  return value.cast<const MotionPrior&>();
}

void bind_motion(py::module_& module) {
  bind_prior(module);
  const GyroNoise usual;
  py::class_<Gyroscope>(
      module, "Gyroscope",
      "Turns a gyroscope's samples into priors, and learns its bias and its clock from tracked poses.\n"
      "Not for several threads at once.")
      .def(py::init(&make_gyroscope), py::arg("R_camera_body") = py::none(),
           py::arg("noise_density") = usual.density_radps_rthz,
           py::arg("bias_walk") = usual.bias_walk_radps2_rthz, py::arg("first_bias") = usual.first_bias_radps,
           py::arg("kept_s") = Gyroscope::Options().kept_s,
           "`R_camera_body`: (3, 3), takes the sensor's axes to the camera's; None: they are the same.\n"
           "`noise_density`: white noise [rad/s/sqrt(Hz)].\n"
           "`bias_walk`: random walk of the bias [rad/s^2/sqrt(Hz)].\n"
           "`first_bias`: standard deviation of the bias before any was measured [rad/s].\n"
           "`kept_s`: samples older than this before the newest are forgotten [s]. Give math.inf if a whole\n"
           "recording is added first.")
      .def("add", &add_samples, py::arg("timestamp"), py::arg("omega"),
           "One sample, or many. `timestamp`: a number or (n,) [s], of the clock of the images.\n"
           "`omega`: (3,) or (n, 3), rate of turn about the sensor's axes [rad/s].\n"
           "Ignored are repeated stamps, samples that are not finite, and those more than 0.03 s late.")
      .def("prior", &Gyroscope::prior, py::arg("from_s"), py::arg("to_s"),
           "How the camera turned between the stamps of two images [s]. None: no samples cover that time.")
      .def(
          "observe",
          [](Gyroscope& self, double from_s, double to_s, py::handle rotation) {
            self.observe(from_s, to_s, rotation_of("rotation", rotation));
          },
          py::arg("from_s"), py::arg("to_s"), py::arg("rotation"),
          "A turn that tracking measured between two stamps [s]: (3, 3) R_current_reference.\n"
          "Bias and clock are learned from it. A wrong one among many does no harm.")
      .def_property_readonly(
          "bias", [](const Gyroscope& g) { return numbers_of(g.bias_radps()); },
          "(3,) float64 [rad/s], in the sensor's axes")
      .def_property_readonly("bias_sigma", &Gyroscope::bias_sigma_radps,
                             "standard deviation of an axis [rad/s]")
      .def_property_readonly("offset", &Gyroscope::offset_s,
                             "by which stamps of samples are late against those of images [s]")
      .def_property_readonly("offset_sigma", &Gyroscope::offset_sigma_s, "its standard deviation [s]");
  module.def(
      "read_gyroscope", &read_samples, py::arg("path"),
      "A gyroscope's samples: (timestamps (n,) [s], omegas (n, 3) [rad/s], R_camera_body (3, 3)).\n"
      "Lines `timestamp wx wy wz`, or EuRoC's imu0/data.csv with sensor.yaml beside it. Raises IoError.");
}

}  // namespace dynfilter::python
