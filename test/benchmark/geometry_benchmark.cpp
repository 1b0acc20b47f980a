// SPDX-License-Identifier: MIT
// Each line runs ours and the reference alternately in the same run.
// `ratio` is the quotient of the medians.
// References: cv::findFundamentalMat(USAC_FAST), Eigen::umeyama in a RANSAC loop, ceres::Problem with an
// analytic Jacobian, cv::undistortPoints.
#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <ctime>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
#include <dynfilter/geometry/two_view.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>

#include "geometry/rigid_scene.hpp"
#include "geometry/two_view_scene.hpp"

using namespace dynfilter;
using namespace geometry_test;

namespace {

constexpr int kSets = 50;  // rotated, because a small repeated set stays in the cache

double cpu_s() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

/// Mean time per set of both, alternating; the median over the iterations of the benchmark.
template <class Ours, class Anchor>
void compare(benchmark::State& state, Ours ours, Anchor anchor) {
  cv::setNumThreads(1);
  std::vector<double> mine, theirs;
  for (auto _ : state) {
    double a = 0, b = 0;
    for (int set = 0; set < kSets; ++set) {
      const double start = cpu_s();
      ours(set);
      const double middle = cpu_s();
      anchor(set);
      a += middle - start, b += cpu_s() - middle;
    }
    mine.push_back(a / kSets), theirs.push_back(b / kSets);
  }
  state.counters["ours_ms"] = 1e3 * median(mine);
  state.counters["anchor_ms"] = 1e3 * median(theirs);
  state.counters["ratio"] = median(mine) / median(theirs);
}

std::vector<TwoViewScene> two_view_sets(int outliers_percent, const Eigen::Vector3d& t) {
  std::vector<TwoViewScene> sets;
  for (int seed = 1; seed <= kSets; ++seed) {
    TwoViewRecipe recipe;
    recipe.motion = motion(2, {0.3, 1, 0.2}, t);
    recipe.noise_px = 0.3, recipe.seed = seed;
    recipe.mismatch_count = 10 * outliers_percent, recipe.static_count = 1000 - recipe.mismatch_count;
    sets.emplace_back(recipe);
  }
  return sets;
}

double recall(const TwoViewScene& scene, const Matrix9& F) {
  int n = 0;
  for (int i = 0; i < scene.static_count; ++i) {
    n += geometry_test::sampson_distance_px(F, scene.reference[i], scene.current[i]) < 1;
  }
  return n / static_cast<double>(scene.static_count);
}

void two_views(benchmark::State& state) {
  const std::vector<TwoViewScene> sets = two_view_sets(static_cast<int>(state.range(0)), {0.4, 0.1, 0.25});
  const std::vector<int> all = sets[0].all();
  TwoViewEstimator estimator;
  double mine = 0, theirs = 0, runs = 0;
  compare(
      state,
      [&](int i) { mine += recall(sets[i], estimator.estimate(sets[i].reference, sets[i].current, all).F); },
      [&](int i) {
        const cv::Mat F =
            cv::findFundamentalMat(sets[i].reference, sets[i].current, cv::USAC_FAST, 1.0, 0.99);
        Matrix9 m{};
        if (F.rows == 3) std::copy(F.ptr<double>(), F.ptr<double>() + 9, m.begin());
        theirs += recall(sets[i], m), runs += 1;
      });
  state.counters["recall"] = mine / runs;
  state.counters["anchor_recall"] = theirs / runs;
}
BENCHMARK(two_views)->Arg(30)->Arg(50)->ArgName("outliers_percent")->Unit(benchmark::kMillisecond);

std::vector<RigidScene> rigid_sets(double outliers) {
  std::vector<RigidScene> sets;
  for (int seed = 1; seed <= kSets; ++seed) sets.emplace_back(1000, outliers, seed, 1);
  return sets;
}

/// A typical user implementation: umeyama on three points, inliers within 5 cm, 99 % confidence, umeyama on
/// the inliers.
struct UmeyamaRansac {
  Eigen::Matrix3Xd p, c;
  void load(const RigidScene& s) {
    p.resize(3, static_cast<Eigen::Index>(s.reference.size())), c.resizeLike(p);
    for (Eigen::Index i = 0; i < p.cols(); ++i) {
      p.col(i) << s.reference[i].x, s.reference[i].y, s.reference[i].z;
      c.col(i) << s.current[i].x, s.current[i].y, s.current[i].z;
    }
  }
  Eigen::Matrix4d run() const {
    SampleGenerator rng(1);
    const auto n = static_cast<std::uint32_t>(p.cols());
    Eigen::Matrix4d best = Eigen::Matrix4d::Identity();
    int best_count = 0, needed = 300;
    for (int i = 0; i < needed; ++i) {
      std::uint32_t pick[3];
      sample_distinct(rng, n, pick, 3);
      Eigen::Matrix3d a, b;
      for (int k = 0; k < 3; ++k) a.col(k) = p.col(pick[k]), b.col(k) = c.col(pick[k]);
      const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
      const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
      const Eigen::Vector3d t = T.topRightCorner<3, 1>();
      int count = 0;
      for (std::uint32_t k = 0; k < n; ++k) count += (R * p.col(k) + t - c.col(k)).squaredNorm() < 0.0025;
      if (count <= best_count) continue;
      best_count = count, best = T;
      needed = ransac_iterations(count / static_cast<double>(n), 3, 0.99, 300);
    }
    return best;
  }
};

void rigid_ransac(benchmark::State& state) {
  const std::vector<RigidScene> sets = rigid_sets(static_cast<double>(state.range(0)) / 100);
  const std::vector<int> all = sets[0].all();
  RigidMotionOptions options;
  options.refine_iterations = 0;  // search only, like the reference
  RigidMotionEstimator estimator(options);
  std::vector<UmeyamaRansac> anchors(kSets);
  for (int i = 0; i < kSets; ++i) anchors[i].load(sets[i]);
  compare(
      state,
      [&](int i) {
        benchmark::DoNotOptimize(estimator.estimate(camera(), sets[i].reference, sets[i].current, all));
      },
      [&](int i) { benchmark::DoNotOptimize(anchors[i].run()); });
}
BENCHMARK(rigid_ransac)->Arg(30)->Arg(50)->ArgName("outliers_percent")->Unit(benchmark::kMillisecond);

/// Reprojection and depth of one point over a left perturbation (translation, rotation), analytic.
class PoseCost : public ceres::SizedCostFunction<3, 3, 4> {
 public:
  PoseCost(const cv::Point3f& p, const cv::Point3f& c, const RigidMotionOptions& o)
      : p_(p.x, p.y, p.z), c_(c) {
    const double sp = o.depth_noise.sigma_m(p.z), sc = o.depth_noise.sigma_m(c.z);
    wz_ = 1 / std::sqrt(sp * sp + sc * sc);
    wx_ = camera().fx_px / o.pixel_sigma_px, wy_ = camera().fy_px / o.pixel_sigma_px;
  }
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const Eigen::Map<const Eigen::Quaterniond> turn(x[1]);
    const Eigen::Vector3d Rp = turn * p_, q = Rp + Eigen::Map<const Eigen::Vector3d>(x[0]);
    const double inv = 1 / q.z(), u = q.x() * inv, v = q.y() * inv;
    r[0] = wx_ * (u - c_.x / c_.z), r[1] = wy_ * (v - c_.y / c_.z), r[2] = wz_ * (q.z() - c_.z);
    if (!J) return true;
    Eigen::Matrix3d A;
    A << wx_ * inv, 0, -wx_ * u * inv, 0, wy_ * inv, -wy_ * v * inv, 0, 0, wz_;
    if (J[0]) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> T(J[0]);
      T = A;
    }
    if (J[1]) {
      Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> Q(J[1]);
      Q.leftCols<3>() =
          -2 * A * detail::cross_matrix(Rp);  // the manifold's Plus is from the left, half angles
      Q.col(3).setZero();
    }
    return true;
  }

 private:
  Eigen::Vector3d p_;
  cv::Point3d c_;
  double wx_, wy_, wz_;
};

/// q' = exp(delta) q. Its Jacobian passes on the first three columns of the cost.
class LeftTurn : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    const Eigen::Map<const Eigen::Vector3d> d(delta);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(2 * d.norm(), d.norm() > 0 ? d.normalized() : d));
    Eigen::Map<Eigen::Quaterniond> result(out);
    result = turn * Eigen::Map<const Eigen::Quaterniond>(x);
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, 4, 3, Eigen::RowMajor>> m(J);
    m.setIdentity();
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
};

Pose ceres_refine(const RigidScene& scene, const RigidMotionOptions& options, const Pose& start) {
  Eigen::Quaterniond turn(start.R());
  Eigen::Vector3d t = start.t();
  ceres::Problem problem;
  for (std::size_t i = 0; i < scene.reference.size(); ++i) {
    problem.AddResidualBlock(new PoseCost(scene.reference[i], scene.current[i], options),
                             new ceres::TukeyLoss(options.loss_scale), t.data(), turn.coeffs().data());
  }
  problem.SetManifold(turn.coeffs().data(), new LeftTurn);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return Pose::from(turn.toRotationMatrix(), t);
}

Pose near(const Pose& truth) {
  return motion(0.05, {0.2, 1, 0.5}, {0.003, -0.003, 0.003}) * truth;
}

void rigid_refine(benchmark::State& state) {
  const std::vector<RigidScene> sets = rigid_sets(0.1);
  const std::vector<int> all = sets[0].all();
  const RigidMotionOptions options;
  RigidMotionEstimator estimator(options);
  double worst = 0;
  Pose mine;
  compare(
      state,
      [&](int i) {
        mine = estimator.refine(camera(), sets[i].reference, sets[i].current, all, near(sets[i].truth))
                   .T_current_reference;
      },
      [&](int i) {
        worst = std::max(worst, pose_error(ceres_refine(sets[i], options, near(sets[i].truth)), mine));
      });
  state.counters["largest_difference"] = worst;
}
BENCHMARK(rigid_refine)->Unit(benchmark::kMillisecond);

void undistort(benchmark::State& state) {
  Camera c = camera();
  c.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  const std::vector<TwoViewScene> sets = two_view_sets(0, {0.4, 0.1, 0.25});
  std::vector<cv::Point2f> out(1000), twin;
  const cv::Matx33d K(c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
  compare(
      state, [&](int i) { undistort_points(c, sets[i].reference, out); },
      [&](int i) { cv::undistortPoints(sets[i].reference, twin, K, c.distortion, cv::noArray(), K); });
}
BENCHMARK(undistort)->Unit(benchmark::kMillisecond);

void rigid_residuals(benchmark::State& state) {
  const std::vector<RigidScene> sets = rigid_sets(0.3);
  const std::array<double, 36> covariance{};
  int set = 0;
  for (auto _ : state) {
    const RigidScene& s = sets[set++ % kSets];
    const RigidResidualModel model(camera(), s.truth, {}, covariance.data());
    for (int i = 0; i < 1000; ++i) benchmark::DoNotOptimize(model(s.reference[i], s.current[i]).chi2);
  }
}
BENCHMARK(rigid_residuals)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
