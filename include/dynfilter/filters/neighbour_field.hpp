// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/pack.hpp>
#include <opencv2/core.hpp>
#include <tuple>
#include <vector>

namespace dynfilter {

/// Values at features, summed around a position at similar depth.
/// The result does not depend on the order of the features, down to the last bit.
/// Positions that are not finite are skipped.
class NeighbourField {
 public:
  struct Sum {
    float values = 0, weights = 0;
  };

  void clear() {
    places_.clear();
    values_.clear();
    grid_.clear();
  }
  void add(const cv::Point2f& px, float depth_m, float value) {
    places_.push_back(px);
    values_.push_back({px.x, px.y, depth_m, value});
  }
  /// Call after the last add(). `cell_px` is approximately the radius of later queries.
  void build(float cell_px) {
    grid_.build(Span<const cv::Point2f>(places_), cell_px);
    by_place_.clear();
    for (const std::int32_t k : grid_.entries()) by_place_.push_back(values_[static_cast<std::size_t>(k)]);
    // Sums of floats depend on their order, which must not be that of the features.
    grid_.for_each_cell([&](std::size_t begin, std::size_t end) {
      if (end - begin > 1)
        std::sort(by_place_.begin() + static_cast<std::ptrdiff_t>(begin),
                  by_place_.begin() + static_cast<std::ptrdiff_t>(end));
    });
    lay_out();
  }

  /// Sum over positions within `reach_px` whose depth differs by at most `near_m`.
  /// Any depth counts if one of the two is NaN. The weight is 1 - (distance / reach)^2.
  Sum around(const cv::Point2f& px, float depth_m, float reach_px, float near_m) const {
    const float per_reach2 = 1 / (reach_px * reach_px);
    const Four none{};
    Four values{}, weights{};
    grid_.ranges_around(px, reach_px, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; e += kLanes) {
        const Four dx = load(x_, e) - px.x, dy = load(y_, e) - px.y, deeper_m = load(depth_m_, e) - depth_m;
        Four weight = 1 - (dx * dx + dy * dy) * per_reach2;
        weight = weight > 0 ? weight : none;
        weight = (deeper_m > near_m || deeper_m < -near_m) ? none : weight;
        weight = kLane < static_cast<float>(end - e) ? weight : none;
        values += weight * load(value_, e);
        weights += weight;
      }
    });
    return {sum(values), sum(weights)};
  }

 private:
  using Four = detail::Pack::Four;
  static constexpr std::size_t kLanes = 4;
  static constexpr Four kLane{0, 1, 2, 3};

  struct Value {
    float x, y, depth_m, value;
    bool operator<(const Value& o) const {
      return std::tie(y, x, depth_m, value) < std::tie(o.y, o.x, o.depth_m, o.value);
    }
  };

  /// Stores one array per number, sorted by position, so that around() reads four at once.
  void lay_out() {
    const std::size_t n = by_place_.size();
    for (std::vector<float>* column : {&x_, &y_, &depth_m_, &value_}) column->assign(n + kLanes, 0.0F);
    for (std::size_t k = 0; k < n; ++k) {
      const Value& v = by_place_[k];
      x_[k] = v.x, y_[k] = v.y, depth_m_[k] = v.depth_m, value_[k] = v.value;
    }
  }
  static Four load(const std::vector<float>& column, std::size_t at) {
    Four four;
    std::memcpy(&four, column.data() + at, sizeof four);
    return four;
  }
  static float sum(const Four& v) { return (v[0] + v[2]) + (v[1] + v[3]); }

  std::vector<cv::Point2f> places_;
  std::vector<Value> values_, by_place_;
  std::vector<float> x_, y_, depth_m_, value_;
  PointGrid grid_;
};

}  // namespace dynfilter
