// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/inertial/gyro_sample.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// A gyroscope beside a camera. Makes priors on the camera's motion from frame to frame out of its samples.
/// Learns its bias and its clock from the poses of a tracked camera.
///
///     Gyroscope gyroscope({R_camera_body, noise});
///     gyroscope.add(sample);                                          // as they come
///     frame.motion_prior = gyroscope.prior(last_stamp_s, stamp_s);    // before process()
///     gyroscope.observe(last_stamp_s, stamp_s, R_current_reference);  // after the host has tracked both
///
/// Integration: the rate between two samples is linear (the rotation part of Forster, Carlone, Dellaert and
/// Scaramuzza, "On-Manifold Preintegration", T-RO 2017, section VI). The covariance is that of the noise, of
/// the bias, of the clock and of the scale, as a left perturbation of R_current_reference.
/// Calibration, over the last 6 s: the clock's offset is where integrated and observed turns differ least. It
/// is searched on a grid and refined by a parabola. The bias is what then remains of them on average.
/// Cost: a few us a frame. Not for several threads at once.
class Gyroscope {
 public:
  static constexpr double kMostOffset_s = 0.1;  ///< between the clocks, either way
  static constexpr double kMostGap_s = 0.03;    ///< between samples: a longer one is not bridged

  struct Options {
    Eigen::Matrix3d R_camera_body = Eigen::Matrix3d::Identity();  ///< sensor's axes to the camera's
    GyroNoise noise;
    double kept_s = 10;  ///< samples older than this before the newest are forgotten
  };

  explicit Gyroscope(const Options& options);

  /// Repeated stamps are ignored, so are samples that are not finite, or older than kMostGap_s before the
  /// newest. Others may come in any order.
  void add(const GyroSample& sample);
  /// Of the camera's motion between two stamps of images [s]. None: the samples do not cover it.
  std::optional<MotionPrior> prior(double from_s, double to_s) const;
  /// How the camera really turned between two stamps. A wrong one among many does no harm.
  void observe(double from_s, double to_s, const Eigen::Matrix3d& R_current_reference);

  /// In the sensor's axes [rad/s], with the standard deviation of an axis.
  const Eigen::Vector3d& bias_radps() const { return bias_radps_; }
  double bias_sigma_radps() const { return bias_sigma_radps_; }
  /// By which stamps of samples are late against those of images [s], with its standard deviation.
  double offset_s() const { return offset_s_; }
  double offset_sigma_s() const { return offset_sigma_s_; }
  /// False while other axes explain the poses far better than R_camera_body. prior() then says nothing.
  bool axes_fit() const { return axes_fit_; }

 private:
  static constexpr double kScale = 0.01;           ///< error of the rate, of itself: MEMS data sheets
  static constexpr double kFirstOffset_s = 0.002;  ///< standard deviation before any was measured
  static constexpr double kLeastOffset_s = 0.0005;
  // Calibration.
  static constexpr double kWindow_s = 6, kStep_s = 0.005;
  static constexpr std::size_t kFewest = 15, kEvery = 5;  ///< observations
  static constexpr double kBlock_s = 0.5;         ///< errors of poses that follow one another are shared
  static constexpr double kOtherAxes_nats = 2.3;  ///< ten to one
  static constexpr double kNearAxes = 0.87;       ///< cos 30 deg: a mounting a few degrees off is still one
  static constexpr double kExact = 1e-9;          ///< rounding of poses without noise
  static constexpr int kAxes = 3;

  struct Turn {  ///< observed, in the sensor's axes
    double from_s, to_s;
    Eigen::Vector3d rotation_rad;
  };
  struct Rates {   ///< means of one turn [rad/s]
    double block;  ///< number of its half second
    Eigen::Vector3d sensor_radps, observed_radps;
  };
  struct Fit {
    double cost;  ///< mean squared residual [rad^2/s^2]
    Eigen::Vector3d bias_radps;
  };

  /// Whether samples cover the time, of the samples' clock.
  bool covers(double from_s, double to_s) const;
  std::size_t after(double stamp_s) const;  ///< index of the first sample after it
  Eigen::Vector3d rate(double stamp_s) const;
  Eigen::Vector3d integral(double from_s, double to_s) const;
  std::vector<Rates> rates(double offset_s) const;
  Fit fit(double offset_s) const;
  bool other_axes_fit() const;
  void calibrate();

  Options options_;
  std::deque<GyroSample> samples_;        ///< by time
  std::deque<Eigen::Vector3d> integral_;  ///< of the rate, from any moment to each sample [rad]
  std::deque<Turn> turns_;
  Eigen::Vector3d bias_radps_ = Eigen::Vector3d::Zero();
  double bias_sigma_radps_, offset_s_ = 0, offset_sigma_s_ = kFirstOffset_s;
  bool axes_fit_ = true;
  std::size_t observed_ = 0;
};

}  // namespace dynfilter
