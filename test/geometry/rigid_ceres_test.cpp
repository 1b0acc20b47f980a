// SPDX-License-Identifier: MIT
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <dynfilter/geometry/rigid_motion.hpp>

// Ceres includes glog's macros with the same names.
#undef CHECK
#undef CHECK_EQ
#undef CHECK_NE
#undef CHECK_GT
#undef CHECK_LT
#undef CHECK_GE
#undef CHECK_LE
#include "doctest/doctest.h"
#include "geometry/rigid_scene.hpp"

using namespace dynfilter;
using geometry_test::camera;
using geometry_test::RigidScene;

namespace {

/// The cost documented in rigid_points.hpp, implemented independently.
struct Residual {
  cv::Point3f p, c;
  RigidMotionOptions options;

  template <class T>
  bool operator()(const T* rotation, const T* translation, T* r) const {
    const T point[3] = {T(p.x), T(p.y), T(p.z)};
    T q[3];
    ceres::AngleAxisRotatePoint(rotation, point, q);
    for (int i = 0; i < 3; ++i) q[i] += translation[i];
    const double sp = options.depth_noise.sigma_m(p.z), sc = options.depth_noise.sigma_m(c.z);
    const double sz = std::sqrt(sp * sp + sc * sc), s = options.pixel_sigma_px;
    const double fx = camera().fx_px, fy = camera().fy_px;
    r[0] = fx / s * (q[0] / q[2] - double(c.x) / c.z);
    r[1] = fy / s * (q[1] / q[2] - double(c.y) / c.z);
    r[2] = (q[2] - double(c.z)) / sz;
    return true;
  }
};

struct CeresMotion {
  Eigen::Matrix3d R;
  double t[3];
};

CeresMotion solve_with_ceres(const RigidScene& scene, const RigidMotionOptions& options, const Pose& start) {
  double rotation[3];
  CeresMotion out;
  const Eigen::Matrix3d R0 = start.R();
  ceres::RotationMatrixToAngleAxis(R0.data(), rotation);
  std::copy(start.translation_m.begin(), start.translation_m.end(), out.t);
  ceres::Problem problem;
  for (std::size_t i = 0; i < scene.reference.size(); ++i) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Residual, 3, 3, 3>(
                                 new Residual{scene.reference[i], scene.current[i], options}),
                             new ceres::TukeyLoss(options.loss_scale), rotation, out.t);
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.function_tolerance = solver.gradient_tolerance = solver.parameter_tolerance = 1e-14;
  solver.max_num_iterations = 200;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  ceres::AngleAxisToRotationMatrix(rotation, out.R.data());
  return out;
}

}  // namespace

TEST_CASE("rigid motion: the same optimum as ceres::Problem, with and without outliers") {
  for (const double outliers : {0.0, 0.1}) {
    const RigidScene scene(300, outliers, 23, 1);
    RigidMotionOptions options;
    options.refine_iterations = 100;
    RigidMotionEstimator estimator(options);
    const RigidMotion mine =
        estimator.refine(camera(), scene.reference, scene.current, scene.all(), scene.truth);
    const CeresMotion twin = solve_with_ceres(scene, options, scene.truth);
    CAPTURE(outliers);
    REQUIRE(mine.ok);
    for (int i = 0; i < 3; ++i) CHECK(std::abs(mine.T_current_reference.translation_m[i] - twin.t[i]) < 1e-6);
    CHECK((mine.T_current_reference.R() - twin.R).cwiseAbs().maxCoeff() < 1e-6);
  }
}
