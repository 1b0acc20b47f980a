// SPDX-License-Identifier: MIT
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/inertial/gyroscope.hpp>
#include <iterator>

namespace dynfilter {

Gyroscope::Gyroscope(const Options& options)
    : options_(options), bias_sigma_radps_(options.noise.first_bias_radps) {}

void Gyroscope::add(const GyroSample& sample) {
  if (!std::isfinite(sample.timestamp_s) || !sample.omega_radps.allFinite()) return;
  std::size_t at = samples_.size();
  while (at > 0 && samples_[at - 1].timestamp_s >= sample.timestamp_s) --at;
  if (at < samples_.size()) {
    const bool late = sample.timestamp_s < samples_.back().timestamp_s - kMostGap_s;
    if (late || samples_[at].timestamp_s == sample.timestamp_s) return;
  }
  const auto offset = static_cast<std::ptrdiff_t>(at);
  samples_.insert(samples_.begin() + offset, sample);
  integral_.insert(integral_.begin() + offset, Eigen::Vector3d::Zero());
  for (std::size_t k = at; k < samples_.size(); ++k) {
    if (k == 0) continue;
    const GyroSample &a = samples_[k - 1], &b = samples_[k];
    integral_[k] = integral_[k - 1] + (b.timestamp_s - a.timestamp_s) / 2 * (a.omega_radps + b.omega_radps);
  }
  while (samples_.front().timestamp_s < samples_.back().timestamp_s - options_.kept_s)
    samples_.pop_front(), integral_.pop_front();
}

std::size_t Gyroscope::after(double stamp_s) const {
  const auto later = [](double stamp, const GyroSample& sample) { return stamp < sample.timestamp_s; };
  return static_cast<std::size_t>(
      std::distance(samples_.begin(), std::upper_bound(samples_.begin(), samples_.end(), stamp_s, later)));
}

bool Gyroscope::covers(double from_s, double to_s) const {
  if (samples_.empty() || !(from_s < to_s) || from_s < samples_.front().timestamp_s - kMostGap_s ||
      to_s > samples_.back().timestamp_s + kMostGap_s)
    return false;
  for (std::size_t k = std::max<std::size_t>(1, after(from_s));
       k < samples_.size() && samples_[k - 1].timestamp_s < to_s; ++k)
    if (samples_[k].timestamp_s - samples_[k - 1].timestamp_s > kMostGap_s) return false;
  return true;
}

Eigen::Vector3d Gyroscope::rate(double stamp_s) const {
  const std::size_t k = after(stamp_s);
  if (k == 0) return samples_.front().omega_radps;
  if (k == samples_.size()) return samples_.back().omega_radps;
  const GyroSample &a = samples_[k - 1], &b = samples_[k];
  const double share = (stamp_s - a.timestamp_s) / (b.timestamp_s - a.timestamp_s);
  return a.omega_radps + share * (b.omega_radps - a.omega_radps);
}

/// Of the rates: the turn, as long as its axis hardly changes. Good enough to compare, from frame to frame.
Eigen::Vector3d Gyroscope::integral(double from_s, double to_s) const {
  const auto until = [&](double stamp_s) -> Eigen::Vector3d {
    const std::size_t k = std::min(after(stamp_s), samples_.size() - 1);
    return integral_[k] - (samples_[k].timestamp_s - stamp_s) / 2 * (samples_[k].omega_radps + rate(stamp_s));
  };
  return until(to_s) - until(from_s);
}

std::optional<MotionPrior> Gyroscope::prior(double from_s, double to_s) const {
  const double begin_s = from_s + offset_s_, end_s = to_s + offset_s_, whole_s = end_s - begin_s;
  if (!axes_fit_ || !covers(begin_s, end_s)) return std::nullopt;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // R_now_reference
  double now_s = begin_s;
  for (std::size_t k = after(begin_s); now_s < end_s; ++k) {
    const double next_s = k < samples_.size() ? std::min(end_s, samples_[k].timestamp_s) : end_s;
    const Eigen::Vector3d mean = (rate(now_s) + rate(next_s)) / 2 - bias_radps_;
    R = exp_so3(-(next_s - now_s) * (options_.R_camera_body * mean)) * R;
    now_s = next_s;
  }
  const Eigen::Vector3d change = options_.R_camera_body * (rate(end_s) - rate(begin_s)),
                        turn = rotation_vector(R);
  const double density = options_.noise.density_radps_rthz;
  const double isotropic2 =
      density * density * whole_s + bias_sigma_radps_ * bias_sigma_radps_ * whole_s * whole_s;
  const Eigen::Matrix3d covariance = isotropic2 * Eigen::Matrix3d::Identity() +
                                     offset_sigma_s_ * offset_sigma_s_ * change * change.transpose() +
                                     kScale * kScale * turn * turn.transpose();
  return MotionPrior::turn(R, covariance);
}

void Gyroscope::observe(double from_s, double to_s, const Eigen::Matrix3d& R_current_reference) {
  if (!is_rigid(Pose::from(R_current_reference, Eigen::Vector3d::Zero())) || !(from_s < to_s)) return;
  turns_.push_back(
      {from_s, to_s, -(options_.R_camera_body.transpose() * rotation_vector(R_current_reference))});
  while (std::abs(turns_.front().from_s - to_s) > kWindow_s) turns_.pop_front();  // in reverse, too
  if (++observed_ % kEvery == 0 && turns_.size() >= kFewest) calibrate();
}

std::vector<Gyroscope::Rates> Gyroscope::rates(double offset_s) const {
  std::vector<Rates> rates;
  for (const Turn& turn : turns_) {
    const double begin_s = turn.from_s + offset_s, end_s = turn.to_s + offset_s, time_s = end_s - begin_s;
    if (covers(begin_s, end_s))
      rates.push_back(
          {std::floor(begin_s / kBlock_s), integral(begin_s, end_s) / time_s, turn.rotation_rad / time_s});
  }
  return rates;
}

/// Cauchy's weights at the median residual make a wrong pose of the host harmless.
Gyroscope::Fit Gyroscope::fit(double offset_s) const {
  const std::vector<Rates> pairs = rates(offset_s);
  if (pairs.size() < kFewest) return {HUGE_VAL, bias_radps_};
  std::vector<Eigen::Vector3d> rates;
  for (const Rates& pair : pairs) rates.push_back(pair.sensor_radps - pair.observed_radps);
  Eigen::Vector3d bias;
  std::vector<double> axis(rates.size());
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < rates.size(); ++i) axis[i] = rates[i][k];
    bias[k] = median_in_place(axis);
  }
  for (std::size_t i = 0; i < rates.size(); ++i) axis[i] = (rates[i] - bias).squaredNorm();
  const double usual2 = median_in_place(axis) + 1e-12;
  double weights = 0, cost = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& rate : rates) {
    const double miss2 = (rate - bias).squaredNorm(), weight = 1 / (1 + miss2 / (4 * usual2));
    weights += weight;
    sum += weight * rate;
    cost += weight * miss2;
  }
  return {cost / weights, sum / weights};
}

/// Against the orthogonal matrix that turns one into the other best (Schoenemann, Psychometrika 1966), by the
/// likelihood of the residuals.
bool Gyroscope::other_axes_fit() const {
  const std::vector<Rates> pairs = rates(offset_s_);
  if (pairs.size() < kFewest) return false;
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero(), observed = Eigen::Vector3d::Zero();
  for (const Rates& pair : pairs) sensor += pair.sensor_radps / n, observed += pair.observed_radps / n;
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double squares = 0, blocks = 0, last = HUGE_VAL;
  for (const Rates& pair : pairs) {
    const Eigen::Vector3d a = pair.sensor_radps - sensor, b = pair.observed_radps - observed;
    products += a * b.transpose();
    squares += a.squaredNorm() + b.squaredNorm();
    if (pair.block != last) blocks += 1, last = pair.block;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squared(products.transpose() * products,
                                                               Eigen::EigenvaluesOnly);
  const double in_best = squared.eigenvalues().cwiseMax(0).cwiseSqrt().sum(), in_own = products.trace();
  if (in_own > kNearAxes * in_best) return false;
  const double best = squares - 2 * in_best, own = squares - 2 * in_own;
  return kAxes / 2.0 * blocks * std::log(own / std::max(best, kExact * squares)) > kOtherAxes_nats;
}

void Gyroscope::calibrate() {
  const int steps = static_cast<int>(std::lround(kMostOffset_s / kStep_s));
  std::vector<double> costs;
  for (int k = -steps; k <= steps; ++k) costs.push_back(fit(k * kStep_s).cost);
  const int best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  const auto n = static_cast<double>(turns_.size());
  if (best > 0 && best < 2 * steps) {
    const auto at = [&](int k) { return costs[static_cast<std::size_t>(k)]; };
    const double curvature = at(best - 1) - 2 * at(best) + at(best + 1);
    const double shift = curvature > 0 ? (at(best - 1) - at(best + 1)) / (2 * curvature) : 0;
    const double offset_s = (best - steps + shift) * kStep_s;
    // The cost is a variance of three axes: the offset's own follows from where chi-square rises by one.
    const double sigma_s = curvature > 0 ? kStep_s * std::sqrt(2 * at(best) / (n * curvature)) : HUGE_VAL;
    if (sigma_s < kFirstOffset_s) {
      offset_s_ = offset_s;
      offset_sigma_s_ = std::max(kLeastOffset_s, sigma_s);
    }
  }
  axes_fit_ = !other_axes_fit();
  const Fit fitted = fit(offset_s_);
  if (!std::isfinite(fitted.cost)) return;
  bias_radps_ = fitted.bias_radps;
  const double window_s = std::abs(turns_.back().to_s - turns_.front().from_s);
  bias_sigma_radps_ = std::sqrt(fitted.cost / n + options_.noise.bias_walk_radps2_rthz *
                                                      options_.noise.bias_walk_radps2_rthz * window_s);
}

}  // namespace dynfilter
