// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter {

/// How well a motion that some points follow agrees with a prior on the camera's motion. With delta the
/// motion from one to the other, as a left perturbation, and J_k its effect on the image of point k,
///   d^2 = delta' M delta / (s^2 + trace(C M)),   M = mean_k J_k' J_k,
/// the mean squared distance in the image over what noise s and the prior's covariance C allow. A prior
/// without a translation leaves it free: M is then the Schur complement of the rotation. So a small object,
/// whose turn is hard to see, contradicts no turn.
class PriorEvidence {
 public:
  /// Refers to both, which must outlive it.
  PriorEvidence(const MotionPrior& prior, const Camera& camera) : prior_(prior), camera_(camera) {}

  /// A point that follows the motion, in the current camera [m].
  void add(const cv::Point3f& point_m);
  /// d^2 of `T_current_reference`, with `noise_px` the error of its image. 0 with fewer than 6 points.
  double distance2(const Pose& T_current_reference, double noise_px) const;
  /// By how much a motion at this distance contradicts the prior [nats]. Negative: it agrees.
  static double contradiction(double distance2) { return distance2 / 2 - kAgreement; }
  /// Log-likelihood of a motion at this distance. `wrong`: the probability that the prior is. All motions
  /// that agree are equally likely: their errors share what neither covariance knows.
  static double log_likelihood(double distance2, double wrong) {
    const double likelihood = portable::exp(-std::max(0.0, contradiction(distance2)));
    return portable::log((1 - wrong) * likelihood + wrong);
  }

 private:
  static constexpr int kFewestPoints = 6;
  static constexpr double kAgreement = 2;  ///< [nats] two deviations, d = 2
  static constexpr double kRidge = 1e-9;   ///< of the trace: few points leave a direction free

  /// Makes M the Schur complement of the unknowns after k, in these.
  static void eliminate(double (&M)[6][6], int k);

  const MotionPrior& prior_;
  const Camera& camera_;
  double M_[6][6] = {};
  int points_ = 0;
};

/// The probability that a prior on the camera's motion is wrong, learned over time. A clock that is late, a
/// bias or wrong axes contradict the background's motion frame after frame. A background that is wrong for a
/// moment, or a jerk, does so once. Log-odds, with the squared distance d^2 of the background's motion:
///   odds += (elapsed / memory) contradiction(d^2), within +-5.
/// Before a prior has proved itself it is as likely wrong as right.
class PriorWatch {
 public:
  static constexpr double kMostOdds = 5;  ///< doubt and trust can both be overcome in half a second
  static constexpr double kMemory_s = 0.25;
  static constexpr double kMost = 25;  ///< d^2 of one frame

  /// In [0, 1].
  double wrong() const { return 1 / (1 + portable::exp(-odds_)); }
  bool trusts() const { return odds_ <= 0; }  ///< whether it is not rather wrong than right
  /// d^2 of this frame's background (PriorEvidence::distance2()), and the time since the last frame [s].
  void observe(double distance2, double elapsed_s) {
    const double now = std::min(1.0, elapsed_s / kMemory_s);
    odds_ += now * PriorEvidence::contradiction(std::min(distance2, kMost));
    odds_ = std::clamp(odds_, -kMostOdds, kMostOdds);
  }
  void reset() { *this = {}; }  ///< another stream

 private:
  double odds_ = 0;
};

inline void PriorEvidence::add(const cv::Point3f& point_m) {
  const Eigen::Vector3d q(point_m.x, point_m.y, point_m.z);
  const double fx = camera_.fx_px / q.z(), fy = camera_.fy_px / q.z();
  const Eigen::Vector3d shift[2] = {{fx, 0, -fx * q.x() / q.z()}, {0, fy, -fy * q.y() / q.z()}};
  for (const Eigen::Vector3d& du : shift) {
    const Eigen::Vector3d turn = q.cross(du);  // a turn by w moves q by w x q
    const double J[6] = {du.x(), du.y(), du.z(), turn.x(), turn.y(), turn.z()};
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c) M_[r][c] += J[r] * J[c];
  }
  ++points_;
}

inline double PriorEvidence::distance2(const Pose& T_current_reference, double noise_px) const {
  if (points_ < kFewestPoints) return 0;
  const Pose delta = prior_.T_current_reference * inverse(T_current_reference);
  const Eigen::Vector3d turn = rotation_vector(delta.R()), shift = delta.t();
  const double d[6] = {shift.x(), shift.y(), shift.z(), turn.x(), turn.y(), turn.z()};
  double M[6][6];
  for (int k = 0; k < 36; ++k) M[k / 6][k % 6] = M_[k / 6][k % 6] / points_;
  int first = 0;
  if (!prior_.has_translation) {
    const double ridge = kRidge * (M[0][0] + M[1][1] + M[2][2]);
    for (int k = 0; k < 3; ++k) M[k][k] += ridge;
    for (; first < 3; ++first) eliminate(M, first);
  }
  const double* const C = prior_.covariance.data();
  double miss2 = 0, allowed2 = noise_px * noise_px;
  for (int r = first; r < 6; ++r)
    for (int c = first; c < 6; ++c) {
      miss2 += d[r] * M[r][c] * d[c];
      allowed2 += C[6 * r + c] * M[c][r];
    }
  return miss2 / allowed2;
}

inline void PriorEvidence::eliminate(double (&M)[6][6], int k) {
  for (int r = k + 1; r < 6; ++r)
    for (int c = k + 1; c < 6; ++c) M[r][c] -= M[r][k] * M[k][c] / M[k][k];
}

}  // namespace dynfilter
