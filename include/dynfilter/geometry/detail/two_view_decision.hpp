// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/geometry/detail/two_view_points.hpp>
#include <dynfilter/geometry/detail/two_view_refine.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <limits>
#include <vector>

namespace dynfilter {

namespace detail {

/// The decision between F, H and "no baseline".
///
/// F = [e']x H fits any scene that H fits, for every e'. The matches that H does not explain, often movers,
/// then choose e'. Counting inliers therefore always prefers F. Let S be the seeds that H explains, and O the
/// others. The tests are, in this order:
///
/// 1. S is less than half of F's support: **Fundamental** (General).
/// 2. The residuals of H at S are isotropic noise if H is the whole truth. Parallax of the static scene has
///    the direction of the epipolar lines. e' is estimated from S alone, so movers in O cannot choose it: it
///    minimises the residuals' second moment across the lines, relative to isotropic noise (a 3x3 generalised
///    eigenproblem). A ratio of the variances along and across above 1 + 12 / sqrt|S| means parallax. F is
///    then fitted starting from that e'. If O has static points within the range that this parallax predicts:
///    **Fundamental** (PlaneAndParallax; Irani and Anandan, PAMI 1998). Else **Homography** with an allowance
///    of four standard deviations along the lines (WeakParallax): a baseline of millimetres.
/// 3. With a camera, K R K^-1 explains S: **Rotation** (PureRotation, NoMotion). O are movers.
/// 4. With a camera, H = K (R + t n^T / d) K^-1 determines e' = K t (Ma et al., An Invitation to 3-D Vision,
///    section 5.3.3). If points of O are on these lines: **Fundamental** (CalibratedParallax).
/// 5. Else **Homography** (Plane). O are movers or a second static surface. GRIC (Torr, PTRSA 1998; weights
///    lambda 2, ln 4) prefers F if O on F is more than 0.39 / 2.0 = 19 % of the seeds. Above
///    `min_parallax_share` the model is therefore `ambiguous` and judges only points that agree with neither
///    F nor H. This also applies in case 3, except for a static camera, which two surfaces cannot imitate.
class TwoViewDecision {
 public:
  TwoViewDecision(const TwoViewPoints& points, const TwoViewOptions& options, double tau2,
                  const Camera* camera, std::vector<float>& scratch)
      : points_(points), options_(options), tau2_(tau2), scratch_(scratch) {
    if (camera == nullptr || !camera->valid()) return;
    const Eigen::Matrix3d K = camera_matrix(*camera);
    calibration_ = {times(points.T1(), K).inverse(), times(points.T2(), K).inverse()};
    calibrated_ = true;
  }

  void decide(const Eigen::Matrix3d* F, const Eigen::Matrix3d* H, TwoViewModel& model) {
    model.reason = TwoViewReason::NoConsensus;
    const double enough = std::max(8.0, options_.min_inlier_share * static_cast<double>(points_.count()));
    model.fundamental_inliers = F ? fundamental_inliers(*F) : 0;
    model.homography_inliers = H ? homography_inliers(*H) : 0;
    const bool rival = model.homography_inliers >= enough &&
                       model.homography_inliers >= options_.min_plane_share * model.fundamental_inliers;
    if (rival) {
      decide_plane(F, *H, model);
    } else if (model.fundamental_inliers >= enough) {
      accept_fundamental(*F, TwoViewReason::General, model);
    }
  }

 private:
  /// Ratio along to across: parallax well above the noise.
  static constexpr double kStrong = 3;
  /// Share of seeds just off H but on its lines: parallax continues there.
  static constexpr double kNearShare = 0.03;
  static constexpr double kRounding = 4e-4;  ///< variance of exact data, in tau^2
  static constexpr std::uint32_t kMaxOff = 512;
  static constexpr double kAnywhere = std::numeric_limits<double>::infinity();

  struct Residuals {
    Eigen::Vector3d epipole;
    double along2 = 0, across2 = 0;
    bool parallax = false;
  };

  static Span<const double> three() {
    static constexpr double kSame[3] = {1, 1, 1};
    return {kSame, 3};
  }

  int fundamental_inliers(const Eigen::Matrix3d& F) const {
    return points_.inliers(FundamentalError(F), tau2_);
  }
  int homography_inliers(const Eigen::Matrix3d& H) const {
    return points_.inliers(HomographyError(H), tau2_);
  }

  void decide_plane(const Eigen::Matrix3d* F, const Eigen::Matrix3d& H, TwoViewModel& model) {
    Eigen::Matrix3d better;
    if (search_parallax(F, H, better)) {
      F = &better;
      model.fundamental_inliers = fundamental_inliers(better);
    }
    const Residuals residuals = measure_residuals(H);
    model.anisotropy = residuals.along2 / residuals.across2;
    if (residuals.parallax) return decide_parallax(F, H, residuals, model);
    if (calibrated_ && decide_rotation(F, H, model)) return;
    if (calibrated_ && decide_calibrated(H, model)) return;
    accept_homography(H, TwoViewKind::Homography, TwoViewReason::Plane, model);
    set_ambiguous(F, H, model);
  }

  /// Plane and parallax of DEGENSAC (Chum et al. 2005, section 3.2). Seven matches that are nearly all on a
  /// plane determine only H. Two matches of O add e', F = [e']x H. True if this F has a better score.
  bool search_parallax(const Eigen::Matrix3d* F, const Eigen::Matrix3d& H, Eigen::Matrix3d& better) {
    fill_errors(H);
    std::uint32_t off[kMaxOff];
    std::uint32_t n = 0;
    for (std::size_t i = 0; i < points_.count() && n < kMaxOff; ++i) {
      if (scratch_[i] > 2 * tau2_) off[n++] = static_cast<std::uint32_t>(i);
    }
    if (n < 10) return false;
    double best = F ? points_.cost(FundamentalError(*F), tau2_, kAnywhere) : kAnywhere;
    const double start = best;
    SampleGenerator rng(options_.seed + 2);
    for (int i = 0; i < 60; ++i) {
      std::uint32_t pick[2];
      sample_distinct(rng, n, pick, 2);
      const auto line = [&](std::uint32_t k) -> Eigen::Vector3d {
        const Eigen::Vector3d there = H * lifted(points_.reference(off[k]));
        return there.cross(lifted(points_.current(off[k])));
      };
      const Eigen::Matrix3d candidate =
          times(cross_matrix(line(pick[0]).cross(line(pick[1]))), H).normalized();
      const double cost = points_.cost(FundamentalError(candidate), tau2_, best);
      if (cost < best) best = cost, better = candidate;
    }
    if (!(best < start)) return false;
    refine_fundamental(points_, 2 * tau2_, three(), {}, better);
    return true;
  }

  /// Step 2: distribution of the residuals of H at S, and the e' that they point to.
  Residuals measure_residuals(const Eigen::Matrix3d& H) const {
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero(), noise = Eigen::Matrix3d::Zero();
    for_plane(H, [&](const Eigen::Vector2d& q, const Eigen::Vector2d& d) {
      const Eigen::Vector3d line(-d.y(), d.x(), q.x() * d.y() - q.y() * d.x());
      moment.noalias() += line * line.transpose();
      noise(0, 0) += 1, noise(0, 2) -= q.x(), noise(1, 2) -= q.y(), noise(2, 2) += q.squaredNorm();
    });
    noise(1, 1) = noise(0, 0), noise(2, 0) = noise(0, 2), noise(2, 1) = noise(1, 2);
    Residuals out;
    out.epipole = least_against(moment, noise);
    double n = 0;
    for_plane(H, [&](const Eigen::Vector2d& q, const Eigen::Vector2d& d) {
      const Eigen::Vector3d& e = out.epipole;
      const Eigen::Vector2d u = Eigen::Vector2d(e.x() - e.z() * q.x(), e.y() - e.z() * q.y()).normalized();
      const double along = u.dot(d), across = u.x() * d.y() - u.y() * d.x();
      out.along2 += along * along, out.across2 += across * across, n += 1;
    });
    const double floor = kRounding * tau2_;  // rounding noise is not isotropic either
    out.along2 = out.along2 / n + floor, out.across2 = out.across2 / n + floor;
    out.parallax = out.along2 > (1 + 8 / std::sqrt(n)) * out.across2;
    return out;
  }

  /// The direction v that minimises v^T A v / v^T B v. B is positive definite.
  /// Eigen's generalised solver takes three seconds to compile per file.
  static Eigen::Vector3d least_against(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
    Eigen::Matrix3d L = Eigen::Matrix3d::Zero();
    for (int c = 0; c < 3; ++c)
      for (int r = c; r < 3; ++r) {
        double sum = B(r, c);
        for (int k = 0; k < c; ++k) sum -= L(r, k) * L(c, k);
        L(r, c) = r == c ? std::sqrt(sum) : sum / L(c, c);
      }
    const Eigen::Matrix3d L_inv = L.inverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(times(times(L_inv, A), L_inv.transpose()));
    const Eigen::Matrix3d back = L_inv.transpose();
    const Eigen::Vector3d v = back * column(solver.eigenvectors(), 0);
    return v.normalized();
  }

  /// Calls visit(H x1, x2 - H x1) for every seed of S.
  template <class Visit>
  void for_plane(const Eigen::Matrix3d& H, Visit visit) const {
    const double limit = tau2_ * kTransferScale;
    for (std::size_t i = 0; i < points_.count(); ++i) {
      const Eigen::Vector2d q = mapped(H, points_.reference(i));
      const Eigen::Vector2d d = points_.current(i) - q;
      if (d.squaredNorm() <= limit) visit(q, d);
    }
  }

  void decide_parallax(const Eigen::Matrix3d* F, const Eigen::Matrix3d& H, const Residuals& residuals,
                       TwoViewModel& model) {
    const double window = std::sqrt(tau2_ * kTransferScale), near = 2.2 * window;
    // Across the lines: noise of both images.
    const double tight2 = std::min(tau2_, 9 * residuals.across2 / 2);
    Eigen::Matrix3d mine = times(cross_matrix(residuals.epipole), H);
    refine_within(H, window, 2 * tight2, mine);
    const double n = static_cast<double>(points_.count()), off = n - model.homography_inliers;
    const int all = parallax_support(mine, H, kAnywhere);
    const bool strong = residuals.along2 > kStrong * residuals.across2 && all >= 0.5 * off;
    if (strong || parallax_support(mine, H, near) >= kNearShare * n) {
      refine_within(H, near, 2 * tight2, mine);
      if (F && explains_near(H, near, tight2, *F, mine)) {
        mine = *F;
      } else if (strong) {
        refine_within(H, kAnywhere, 2 * tight2, mine);
      } else {
        grow(H, near, 2 * tight2, mine);
      }
      return accept_fundamental(mine, TwoViewReason::PlaneAndParallax, model);
    }
    accept_homography(H, TwoViewKind::Homography, TwoViewReason::WeakParallax, model);
    model.F = fundamental_px(mine);
    model.allowance_px = 4 * std::sqrt(residuals.along2 - residuals.across2) / points_.scale();
  }

  /// True if F explains the parallax near H as well as the F fitted to that parallax only.
  /// The test is chi-square with seven parameters at 99 %. It rejects an F that is biased by movers.
  bool explains_near(const Eigen::Matrix3d& H, double near, double tight2, const Eigen::Matrix3d& F,
                     const Eigen::Matrix3d& fitted) {
    constexpr double kSlack = 18.48 / 9;  // costs are in units of tight2 = 9 sigma^2
    return cost_within(H, near, F, tight2) < cost_within(H, near, fitted, tight2) + kSlack;
  }

  /// Extends F outwards while each ring of parallax contains static points.
  /// Static parallax has no gap, so a group of movers beyond a gap is excluded.
  void grow(const Eigen::Matrix3d& H, double reach, double cut2, Eigen::Matrix3d& F) {
    const double enough = 0.01 * static_cast<double>(points_.count());
    for (int ring = 0; ring < 12; ++ring, reach *= 1.3) {
      if (parallax_support(F, H, 1.3 * reach) - parallax_support(F, H, reach) < enough) break;
      refine_within(H, 1.3 * reach, cut2, F);
    }
  }

  /// Refines F on the seeds within `reach` of their position under H.
  void refine_within(const Eigen::Matrix3d& H, double reach, double cut2, Eigen::Matrix3d& F) {
    fill_errors(H);
    const float limit = static_cast<float>(reach * reach / kTransferScale);
    refine_fundamental(points_, cut2, three(), {points_.count(), scratch_.data(), limit}, F);
  }

  double cost_within(const Eigen::Matrix3d& H, double reach, const Eigen::Matrix3d& F, double tau2) {
    fill_errors(H);
    const double limit = reach * reach / kTransferScale;
    double sum = 0;
    points_.visit(FundamentalError(F), [&](std::size_t i, float e) {
      if (scratch_[i] <= limit) sum += std::min(1.0, e / tau2);
    });
    return sum;
  }

  void fill_errors(const Eigen::Matrix3d& H) {
    scratch_.resize(points_.count());
    points_.visit(HomographyError(H), [&](std::size_t i, float e) { scratch_[i] = e; });
  }

  /// Number of seeds on F that are within `reach` of their position under H, but off H.
  /// Off H means `clear` times the bound on squared errors, well above noise.
  int parallax_support(const Eigen::Matrix3d& F, const Eigen::Matrix3d& H, double reach,
                       double clear = 2) const {
    int n = 0;
    const double off2 = clear * tau2_ * kTransferScale;
    points_.visit(FundamentalError(F), [&](std::size_t i, float e) {
      if (e > tau2_) return;
      const Eigen::Vector2d q = mapped(H, points_.reference(i));
      const Eigen::Vector2d d = points_.current(i) - q;
      const double d2 = d.squaredNorm();
      n += d2 > off2 && d2 <= reach * reach;
    });
    return n;
  }

  bool decide_rotation(const Eigen::Matrix3d* F, const Eigen::Matrix3d& H, TwoViewModel& model) {
    const Eigen::Matrix3d G = times(times(calibration_.K2_inv, H), calibration_.K1_inv.inverse());
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(G, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d R = times(svd.matrixU(), svd.matrixV().transpose());
    if (R.determinant() < 0) R = -R;
    for (double cut : {64.0, 16.0, 4.0}) refine_rotation(points_, calibration_, cut * tau2_, 1, {320}, R);
    refine_rotation(points_, calibration_, 2 * tau2_, 2, {}, R);
    const Eigen::Matrix3d infinite = calibration_.rotation(R);
    if (homography_inliers(infinite) < 0.97 * model.homography_inliers) return false;
    if (plane_residual2(H, infinite) > 1.2 * plane_residual2(H, H)) return false;
    const bool still = stood_still();
    accept_homography(infinite, TwoViewKind::Rotation,
                      still ? TwoViewReason::NoMotion : TwoViewReason::PureRotation, model);
    if (!still) set_ambiguous(F, infinite, model);
    return true;
  }

  /// Mean squared error of `model` over S, plus the rounding error of exact data.
  double plane_residual2(const Eigen::Matrix3d& H, const Eigen::Matrix3d& model) {
    fill_errors(H);
    double sum = 0, n = 0;
    points_.visit(HomographyError(model), [&](std::size_t i, float e) {
      if (scratch_[i] <= tau2_) sum += e, n += 1;
    });
    return sum / n + kRounding * tau2_;
  }

  /// True if half of the seeds have not moved.
  bool stood_still() const {
    const Eigen::Matrix3d identity_px = times(points_.T2(), points_.T1().inverse());
    return homography_inliers(identity_px) >= 0.5 * static_cast<double>(points_.count());
  }

  /// Step 4.
  bool decide_calibrated(const Eigen::Matrix3d& H, TwoViewModel& model) {
    Essential candidates[2];
    const int n = decompose(times(times(calibration_.K2_inv, H), calibration_.K1_inv.inverse()), candidates);
    int best_support = 0;
    Eigen::Matrix3d best;
    for (int c = 0; c < n; ++c) {
      refine_essential_within(H, 2 * tau2_, candidates[c]);
      const Eigen::Matrix3d F = calibration_.fundamental(candidates[c]).normalized();
      if (fundamental_inliers(F) < 0.95 * model.homography_inliers) continue;
      const int support = parallax_support(F, H, kAnywhere);
      if (support > best_support) best_support = support, best = F;
    }
    const int off = static_cast<int>(points_.count()) - model.homography_inliers;
    // Movers of any direction are sometimes within 1 px of these lines. More support is therefore required.
    if (best_support < 10 || best_support < 0.4 * off) return false;
    accept_fundamental(best, TwoViewReason::CalibratedParallax, model);
    return true;
  }

  /// Uses S only: the epipole that judges O must not depend on O.
  void refine_essential_within(const Eigen::Matrix3d& H, double cut2, Essential& e) {
    fill_errors(H);
    const Selection plane{points_.count(), scratch_.data(), static_cast<float>(tau2_)};
    refine_essential(points_, calibration_, cut2, 3, plane, e);
  }

  /// Decomposes a plane's G = R + t n^T, up to scale, into its two motions (R, t / |t|).
  static int decompose(Eigen::Matrix3d G, Essential (&out)[2]) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(G, Eigen::ComputeFullV);
    G /= std::copysign(svd.singularValues()(1), G.determinant());
    const Eigen::Vector3d s = svd.singularValues() / svd.singularValues()(1);
    const double a2 = 1 - s(2) * s(2), b2 = s(0) * s(0) - 1;
    if (!(a2 + b2 > 1e-9)) return 0;
    Eigen::Matrix3d V = svd.matrixV();
    if (V.determinant() < 0) V = -V;
    for (int k = 0; k < 2; ++k) {
      const double sign = k == 0 ? 1 : -1;
      const Eigen::Vector3d v2 = column(V, 1);
      Eigen::Vector3d u = std::sqrt(std::max(0.0, a2)) * column(V, 0);
      u += sign * std::sqrt(std::max(0.0, b2)) * column(V, 2);
      u /= std::sqrt(a2 + b2);
      u.normalize();
      const Eigen::Vector3d Gv2 = G * v2, Gu = G * u, n = v2.cross(u);
      const Eigen::Matrix3d U = columns(v2, u, n), W = columns(Gv2, Gu, Gv2.cross(Gu));
      const Eigen::JacobiSVD<Eigen::Matrix3d> nearest(times(W, U.transpose()),
                                                      Eigen::ComputeFullU | Eigen::ComputeFullV);
      out[k].R = times(nearest.matrixU(), nearest.matrixV().transpose());
      const Eigen::Matrix3d rest = G - out[k].R;
      const Eigen::Vector3d t = rest * n;
      if (!(t.norm() > 1e-9) || out[k].R.determinant() < 0) return k;
      out[k].t = t.normalized();
    }
    return 2;
  }

  void set_ambiguous(const Eigen::Matrix3d* F, const Eigen::Matrix3d& H, TwoViewModel& model) const {
    if (!F) return;
    const int off = parallax_support(*F, H, kAnywhere, 1.2);
    model.ambiguous = off >= options_.min_parallax_share * static_cast<double>(points_.count());
    if (model.ambiguous) model.F = fundamental_px(*F);
  }

  void accept_fundamental(const Eigen::Matrix3d& F, TwoViewReason reason, TwoViewModel& model) {
    model.kind = TwoViewKind::Fundamental;
    model.reason = reason;
    model.F = fundamental_px(F);
    model.inliers = fundamental_inliers(F);
    model.sigma_px = sigma_px(FundamentalError(F), 0.4549);
  }

  void accept_homography(const Eigen::Matrix3d& H, TwoViewKind kind, TwoViewReason reason,
                         TwoViewModel& model) {
    model.kind = kind;
    model.reason = reason;
    Eigen::Matrix3d px = times(times(points_.T2().inverse(), H), points_.T1());
    px /= px(2, 2);
    model.H = to_array(px);
    model.inliers = homography_inliers(H);
    model.sigma_px = sigma_px(HomographyError(H), 1.3863 * 2 / kTransferScale);
  }

  Matrix9 fundamental_px(const Eigen::Matrix3d& F) const {
    return to_array(times(times(points_.T2().transpose(), F), points_.T1()).normalized());
  }

  /// Noise from the median of the squared errors of inliers. `median` is that of unit noise.
  template <class Error>
  double sigma_px(const Error& error, double median) {
    scratch_.clear();
    points_.visit(error, [&](std::size_t, float e) {
      if (e <= 4 * tau2_) scratch_.push_back(e);
    });
    if (scratch_.empty()) return 0;
    return std::sqrt(median_in_place(scratch_) / median) / points_.scale();
  }

  const TwoViewPoints& points_;
  const TwoViewOptions& options_;
  double tau2_;
  std::vector<float>& scratch_;
  Calibration calibration_;
  bool calibrated_ = false;
};

}  // namespace detail
}  // namespace dynfilter
