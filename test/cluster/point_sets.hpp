// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

/// Point sets for clustering, simple and difficult. Deterministic.
namespace point_sets {

using Points = std::vector<cv::Point3f>;

class Source {
 public:
  explicit Source(unsigned seed) : random_(seed) {}
  float uniform(float low, float high) {
    return low + (high - low) * static_cast<float>(random_() >> 8U) / 16777216.0F;
  }
  /// Unit variance, from twelve uniform numbers.
  float bell() {
    float sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform(0, 1);
    return sum;
  }
  unsigned below(unsigned n) { return static_cast<unsigned>(random_()) % n; }

 private:
  std::mt19937 random_;
};

/// Person-sized clusters at room depth, and some outliers.
inline Points blobs(int n, int blob_count, float sigma_m, unsigned seed) {
  Source source(seed);
  Points centres, points;
  for (int b = 0; b < blob_count; ++b)
    centres.emplace_back(source.uniform(-2, 2), source.uniform(-1, 1), source.uniform(1, 5));
  for (int i = 0; i < n; ++i) {
    if (source.below(10) == 0) {
      points.emplace_back(source.uniform(-3, 3), source.uniform(-2, 2), source.uniform(0.5F, 6));
    } else {
      const cv::Point3f& c = centres[source.below(static_cast<unsigned>(blob_count))];
      points.push_back(c + cv::Point3f(source.bell(), source.bell(), source.bell()) * sigma_m);
    }
  }
  return points;
}

inline Points box(int n, float size_m, unsigned seed) {
  Source source(seed);
  Points points;
  for (int i = 0; i < n; ++i)
    points.emplace_back(source.uniform(0, size_m), source.uniform(0, size_m), source.uniform(0, size_m));
  return points;
}

inline Points lattice(int side, float step_m) {
  Points points;
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      for (int z = 0; z < side; ++z)
        points.push_back(cv::Point3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) *
                         step_m);
  return points;
}

inline Points line(int n, float step_m) {
  Points points;
  for (int i = 0; i < n; ++i) points.emplace_back(1.0F, 2.0F + step_m * static_cast<float>(i), 3.0F);
  return points;
}

inline Points joined(Points a, const Points& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Names and points of difficult inputs for search structures.
inline std::vector<std::pair<std::string, Points>> awkward() {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  const Points odd{{kNan, 0, 0}, {0, kInf, 0}, {0, 0, -kInf}, {kNan, kNan, kNan}};
  Points far = blobs(60, 2, 0.05F, 5);
  for (const float huge : {1e4F, -1e7F, 3e12F, -3e30F, 3e38F})
    for (int i = 0; i < 6; ++i) far.emplace_back(huge, 0.01F * static_cast<float>(i), 2.0F);
  return {
      {"none", {}},
      {"one", {{1, 2, 3}}},
      {"two", {{1, 2, 3}, {1, 2.05F, 3}}},
      {"only odd ones", odd},
      {"all the same", Points(70, cv::Point3f(0.3F, -0.2F, 1.7F))},
      {"pairs of the same", joined(blobs(60, 3, 0.1F, 1), blobs(60, 3, 0.1F, 1))},
      {"line", line(60, 0.04F)},
      {"line at exactly eps", line(40, 0.125F)},
      {"lattice", lattice(6, 0.05F)},
      {"lattice at exactly eps", lattice(5, 0.125F)},
      {"plane",
       [] {
         Points p = box(200, 1.5F, 3);
         for (cv::Point3f& q : p) q.z = 2;
         return p;
       }()},
      {"odd ones among blobs", joined(odd, joined(blobs(100, 2, 0.1F, 4), odd))},
      {"far apart", far},
      {"two heaps a little more than eps apart",
       joined(Points(50, cv::Point3f(0, 0, 0)), Points(50, cv::Point3f(0.1251F, 0, 0)))},
      {"dense and sparse", joined(box(200, 0.1F, 6), box(200, 4, 7))},
  };
}

}  // namespace point_sets
