// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/geometry/detail/two_view_refine.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <numeric>
#include <vector>

#include "doctest/doctest.h"

namespace two_view_refine_test {

using namespace dynfilter;
using detail::EntryNormal;
using detail::Selection;
using detail::TwoViewPoints;

namespace {

/// Matches that move by about 20 px, with 3 px of noise and some outliers.
TwoViewPoints matches(std::size_t n, std::uint64_t seed) {
  SampleGenerator rng(seed);
  std::vector<cv::Point2f> reference, current;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = rng.uniform(0, 640), y = rng.uniform(0, 480), noise_px = i % 5 == 0 ? 60 : 3;
    reference.emplace_back(static_cast<float>(x), static_cast<float>(y));
    current.emplace_back(static_cast<float>(x + 20 + noise_px * rng.normal()),
                         static_cast<float>(y - 5 + noise_px * rng.normal()));
  }
  std::vector<int> seeds(n);
  std::iota(seeds.begin(), seeds.end(), 0);
  TwoViewPoints points;
  points.pack(reference, current, seeds);
  return points;
}

Eigen::Matrix3d near_identity(SampleGenerator& rng) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 9; ++i) m.data()[i] += 0.05 * rng.normal();
  return m;
}

bool taken(const Selection& selection, std::size_t i) {
  return i < selection.count && (selection.errors == nullptr || selection.errors[i] <= selection.limit);
}

using Vector9 = Eigen::Matrix<double, 9, 1>;
struct Twin {
  Eigen::Matrix<double, 9, 9> A = Eigen::Matrix<double, 9, 9>::Zero();
  Vector9 g = Vector9::Zero();
};

void check_equal(const EntryNormal& a, const Twin& b) {
  const Eigen::Map<const Eigen::Matrix<double, 9, 9>> A(a.A[0].data());
  const Eigen::Map<const Vector9> g(a.g.data());
  CHECK((A - b.A).cwiseAbs().maxCoeff() < 1e-4 * b.A.cwiseAbs().maxCoeff());
  CHECK((g - b.g).cwiseAbs().maxCoeff() < 1e-4 * std::max(1.0, b.g.cwiseAbs().maxCoeff()));
}

/// Each match in double: its full Jacobian, with weighted rows.
Twin transfer_twin(const TwoViewPoints& points, const Eigen::Matrix3d& H, double cut2,
                   const Selection& selection) {
  Twin normal;
  for (std::size_t i = 0; i < points.count(); ++i) {
    const Eigen::Vector3d p = points.reference(i).homogeneous(), q = H * p;
    const Eigen::Vector2d at = q.hnormalized(), d = at - points.current(i);
    const double taper = std::max(0.0, 1 - d.squaredNorm() / detail::kTransferScale / cut2);
    if (!taken(selection, i)) continue;
    Eigen::Matrix<double, 2, 9> J;
    J << p.transpose(), 0, 0, 0, -at.x() * p.transpose(), 0, 0, 0, p.transpose(), -at.y() * p.transpose();
    J /= q.z();
    normal.A += taper * taper * J.transpose() * J;
    normal.g += taper * taper * J.transpose() * d;
  }
  return normal;
}

Twin epipolar_twin(const TwoViewPoints& points, const Eigen::Matrix3d& F, double cut2,
                   const Selection& selection) {
  Twin normal;
  for (std::size_t i = 0; i < points.count(); ++i) {
    const Eigen::Vector3d p = points.reference(i).homogeneous(), c = points.current(i).homogeneous();
    const double e = c.dot(F * p),
                 den = (F * p).head<2>().squaredNorm() + (F.transpose() * c).head<2>().squaredNorm();
    const double taper = std::max(0.0, 1 - e * e / den / cut2);
    if (!taken(selection, i)) continue;
    Eigen::Matrix<double, 9, 1> a;
    a << c.x() * p, c.y() * p, p;
    normal.A += taper * taper / den * a * a.transpose();
    normal.g += taper * taper / den * e * a;
  }
  return normal;
}

}  // namespace

TEST_CASE("normal equations of homography and epipolar geometry are those of the Jacobians, match by match") {
  for (const std::size_t n : {8U, 61U, 64U, 331U}) {
    CAPTURE(n);
    const TwoViewPoints points = matches(n, n);
    SampleGenerator rng(n + 1);
    std::vector<float> errors;
    for (std::size_t i = 0; i < n; ++i) errors.push_back(static_cast<float>(rng.uniform(0, 1)));
    for (const Selection& selection :
         {Selection{}, Selection{std::min<std::size_t>(32, n)}, Selection{n, errors.data(), 0.6F}}) {
      const Eigen::Matrix3d H = near_identity(rng),
                            F = detail::cross_matrix(Eigen::Vector3d(1, 0.2, 0.3)) * H;
      EntryNormal normal;
      detail::accumulate_transfer(points, H, 0.2, selection, normal);
      check_equal(normal, transfer_twin(points, H, 0.2, selection));
      detail::accumulate_epipolar(points, F, 0.01, selection, normal);
      check_equal(normal, epipolar_twin(points, F, 0.01, selection));
    }
  }
}

// Such a homography maps points on a line through the matches to infinity.
TEST_CASE("a homography that sends matches to infinity leaves the normal equations finite") {
  const TwoViewPoints points = matches(61, 3);
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity();
  H.row(2) << 1, 0, -points.reference(7).x();
  EntryNormal normal;
  detail::accumulate_transfer(points, H, 0.2, {}, normal);
  CHECK(detail::all_finite(normal.A[0].data(), 81));
  CHECK(detail::all_finite(normal.g.data(), 9));
  H.setZero();
  CHECK_FALSE(detail::accumulate_transfer(points, H, 0.2, {}, normal));
  CHECK(normal.A == std::array<Matrix9, 9>{});
}

}  // namespace two_view_refine_test
