// SPDX-License-Identifier: MIT
#include <Eigen/Dense>
#include <cmath>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/correspondence/patch_spread.hpp>
#include <random>

#include "doctest/doctest.h"

namespace match_spread_test {

using namespace dynfilter;

TEST_CASE("match spread: a corner does not slide, an edge does, along itself") {
  CHECK_FALSE(PatchSpread::of(1, 0, 1).slides());
  CHECK_FALSE(PatchSpread::of(0, 0, 0).slides());
  CHECK_FALSE(PatchSpread::of(1, 0, 1.001 * PatchSpread::kCorner).slides());
  const MatchSpread upright = PatchSpread::of(1, 0, PatchSpread::kCorner / 2);
  CHECK(std::abs(upright.edge.y) == 1.0F);
  CHECK(upright.along == doctest::Approx(16));            // 2^4
  const MatchSpread straight = PatchSpread::of(1, 1, 1);  // gradients along (1, 1)
  CHECK(straight.along == doctest::Approx(PatchSpread::kMost));
  CHECK(straight.edge.x == doctest::Approx(-straight.edge.y));
  CHECK(straight.reliability() == doctest::Approx(1e-4));
}

TEST_CASE("match spread: the axes are those of an eigenvalue solver") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 1000; ++k) {
    Eigen::Matrix2d G;
    G << normal(random), normal(random), normal(random), normal(random);
    const Eigen::Matrix2d M = G * G.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(M);
    const detail::Axes2 axes = detail::axes_of(M(0, 0), M(0, 1), M(1, 1));
    CHECK(axes.most == doctest::Approx(solver.eigenvalues()[1]));
    CHECK(axes.least == doctest::Approx(solver.eigenvalues()[0]).epsilon(1e-6));
    CHECK(std::abs(Eigen::Vector2d(axes.x, axes.y).dot(solver.eigenvectors().col(1))) == doctest::Approx(1));
  }
}

TEST_CASE("verdict: a weight is the probability of standing still times what the match determines") {
  Verdict verdict;
  verdict.decision = {Vote::Static, Vote::Unknown, Vote::Dynamic};
  verdict.suspicion = {0.25F, 0.5F, 0.75F};
  CHECK(verdict.weight(0) == doctest::Approx(0.9));  // 9 to 1
  CHECK(verdict.weight(1) == 1.0F);                  // nothing is known against it
  CHECK(verdict.weight(2) == 0.0F);
  verdict.spread.resize(3);
  verdict.spread[0].along = 10;
  CHECK(verdict.weight(0) == doctest::Approx(0.09));
  CHECK(verdict.weight(1) == 1.0F);
}

}  // namespace match_spread_test
