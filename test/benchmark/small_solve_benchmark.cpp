// SPDX-License-Identifier: MIT
// What is solved and counted by hand, against Eigen: `ratio` below 1 means that ours is faster.
// All of it is in inner loops: samples of RANSAC, steps of refinements, and the score of a hypothesis.
#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <array>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/geometry/detail/two_view_solvers.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <vector>

#include "ratio.hpp"

using namespace dynfilter;

namespace {

constexpr std::size_t kSets = 10,
                      kCalls = 2000;  // calls per set: a single one is shorter than the clock's step

template <class Input, class Make>
std::vector<std::vector<Input>> sets_of(const Make& make) {
  SampleGenerator rng(1);
  std::vector<std::vector<Input>> sets(kSets);
  for (auto& set : sets)
    for (std::size_t k = 0; k < kCalls; ++k) set.push_back(make(rng));
  return sets;
}

/// Runs both on every input of a set. Each returns a number, so that nothing is left out.
template <class Input, class Ours, class Eigens>
void run(benchmark::State& state, const std::vector<std::vector<Input>>& sets, const Ours& ours,
         const Eigens& eigens) {
  const auto all = [&](const auto& f) {
    return [&](std::size_t set) {
      double sum = 0;
      for (const Input& input : sets[set]) sum += f(input);
      benchmark::DoNotOptimize(sum);
    };
  };
  bench::compare(state, kSets, all(ours), all(eigens));
}

template <int N>
struct System {
  Eigen::Matrix<double, N, N, Eigen::RowMajor> A;
  Eigen::Matrix<double, N, 1> b;
};

/// Normal equations of a step: 5 of the view's motion, 6 of a rigid one, 8 of a homography.
template <int N>
void positive_definite(benchmark::State& state) {
  const auto sets = sets_of<System<N>>([](SampleGenerator& rng) {
    Eigen::Matrix<double, N + 4, N> J;
    System<N> s;
    for (double& v : J.reshaped()) v = rng.uniform(-1, 1);
    for (double& v : s.b) v = rng.uniform(-1, 1);
    s.A = J.transpose() * J;
    return s;
  });
  run(
      state, sets,
      [](System<N> s) { return detail::solve_positive_definite(s.A.data(), s.b.data(), N) ? s.b[0] : 0; },
      [](const System<N>& s) { return Eigen::LDLT<Eigen::Matrix<double, N, N>>(s.A).solve(s.b).eval()[0]; });
}
BENCHMARK(positive_definite<5>)->UseManualTime();
BENCHMARK(positive_definite<6>)->UseManualTime();
BENCHMARK(positive_definite<8>)->UseManualTime();

struct SevenRows {
  double A[7][9];
};

/// The null space of seven matches.
void null_space(benchmark::State& state) {
  const auto sets = sets_of<SevenRows>([](SampleGenerator& rng) {
    SevenRows rows;
    for (auto& row : rows.A) {
      const double x = rng.uniform(-1, 1), y = rng.uniform(-1, 1), u = x + rng.uniform(-0.1, 0.1),
                   v = y + rng.uniform(-0.1, 0.1);
      const double values[9] = {u * x, u * y, u, v * x, v * y, v, x, y, 1};
      std::copy(values, values + 9, row);
    }
    return rows;
  });
  run(
      state, sets,
      [](SevenRows rows) {
        Eigen::Matrix3d a, b;
        return detail::null_space_7x9(rows.A, a, b) ? a(0, 0) : 0;
      },
      [](const SevenRows& rows) {
        using Rows = Eigen::Matrix<double, 7, 9, Eigen::RowMajor>;
        const Eigen::FullPivLU<Eigen::Matrix<double, 7, 9>> lu(Eigen::Map<const Rows>(rows.A[0]));
        return lu.kernel().eval()(0, 0);
      });
}
BENCHMARK(null_space)->UseManualTime();

struct FourMatches {
  Eigen::Vector2d p1[4], p2[4];
};

/// The homography of four matches.
void homography(benchmark::State& state) {
  const auto sets = sets_of<FourMatches>([](SampleGenerator& rng) {
    FourMatches m;
    const double x[4] = {-1, 1, 1, -1}, y[4] = {-1, -1, 1, 1};
    for (int k = 0; k < 4; ++k) {
      m.p1[k] = {x[k] + rng.uniform(-0.3, 0.3), y[k] + rng.uniform(-0.3, 0.3)};
      m.p2[k] = {x[k] + rng.uniform(-0.3, 0.3), y[k] + rng.uniform(-0.3, 0.3)};
    }
    return m;
  });
  run(
      state, sets,
      [](const FourMatches& m) {
        Eigen::Matrix3d H;
        return detail::solve_four(m.p1, m.p2, H) ? H(0, 0) : 0;
      },
      [](const FourMatches& m) {
        Eigen::Matrix<double, 8, 8> A;
        Eigen::Matrix<double, 8, 1> b;
        for (int k = 0; k < 4; ++k) {
          const double px = m.p1[k].x(), py = m.p1[k].y(), qx = m.p2[k].x(), qy = m.p2[k].y();
          A.row(2 * k) << px, py, 1, 0, 0, 0, -qx * px, -qx * py;
          A.row(2 * k + 1) << 0, 0, 0, px, py, 1, -qy * px, -qy * py;
          b[2 * k] = qx, b[2 * k + 1] = qy;
        }
        return A.partialPivLu().solve(b).eval()[0];
      });
}
BENCHMARK(homography)->UseManualTime();

/// Points in rows, eight at a time under a motion: the score of a hypothesis.
struct Points {
  static constexpr std::size_t kCount = 1000;
  std::array<float, kCount> x, y, z, u, v;
};

template <class Lanes, class Load, class Positive>
Lanes score(const Points& p, const Lanes& none, const Load& load, const Positive& positive) {
  const Lanes a = none + 0.01F, b = none + 0.02F, inv_limit = none + 25.0F, one = none + 1.0F;
  Lanes sum = none;
  for (std::size_t i = 0; i < Points::kCount; i += 8) {
    const Lanes x = load(&p.x[i]), y = load(&p.y[i]), z = load(&p.z[i]);
    const Lanes qz = a * x + b * y + z;
    const Lanes rx = x + a * z - load(&p.u[i]) * qz, ry = y - b * z - load(&p.v[i]) * qz;
    sum += positive(one - (rx * rx + ry * ry) * inv_limit);
  }
  return sum;
}

void lanes(benchmark::State& state) {
  std::vector<Points> sets(kSets);
  SampleGenerator rng(1);
  for (Points& p : sets)
    for (std::size_t k = 0; k < Points::kCount; ++k) {
      p.x[k] = static_cast<float>(rng.uniform(-1, 1)), p.y[k] = static_cast<float>(rng.uniform(-1, 1));
      p.z[k] = static_cast<float>(rng.uniform(1, 4));
      p.u[k] = p.x[k] / p.z[k], p.v[k] = p.y[k] / p.z[k];
    }
  const auto often = [&](const auto& f) {
    return [&](std::size_t set) {
      for (int k = 0; k < 100; ++k) benchmark::DoNotOptimize(f(sets[set]));
    };
  };
  using detail::Pack;
  using Array = Eigen::Array<float, 8, 1>;
  bench::compare(state, kSets, often([](const Points& p) {
                   return score(
                              p, Pack(0), [](const float* from) { return Pack::load(from); },
                              [](const Pack& fit) { return max(fit, Pack(0)); })
                       .sum();
                 }),
                 often([](const Points& p) {
                   return score(
                              p, Array(Array::Zero()),
                              [](const float* from) { return Array(Eigen::Map<const Array>(from)); },
                              [](const Array& fit) { return Array(fit.max(0)); })
                       .sum();
                 }));
}
BENCHMARK(lanes)->UseManualTime();

}  // namespace

BENCHMARK_MAIN();
