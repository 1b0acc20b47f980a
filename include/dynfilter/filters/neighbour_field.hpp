// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <tuple>
#include <vector>

namespace dynfilter {

/// Values at features' places, to be asked for around a place and at a like depth. What it answers does not
/// depend on the order of the features, to the last bit. Places that are not finite are left out.
class NeighbourField {
 public:
  struct Sum {
    float values = 0, weights = 0;
  };

  void clear() {
    places_.clear();
    values_.clear();
    by_place_.clear();
  }
  void add(const cv::Point2f& px, float depth_m, float value) {
    places_.push_back(px);
    values_.push_back({px.x, px.y, depth_m, value});
  }
  /// After the last add(). `cell_px`: about half of what will be asked for.
  void build(float cell_px) {
    grid_.build(Span<const cv::Point2f>(places_), cell_px);
    by_place_.clear();  // by place, so that around() runs over memory in order
    for (const std::int32_t k : grid_.entries()) by_place_.push_back(values_[static_cast<std::size_t>(k)]);
    // Sums of floats depend on their order, which must not be that of the features.
    grid_.for_each_cell([&](std::size_t begin, std::size_t end) {
      if (end - begin > 1)
        std::sort(by_place_.begin() + static_cast<std::ptrdiff_t>(begin),
                  by_place_.begin() + static_cast<std::ptrdiff_t>(end));
    });
  }

  /// Over the places within `reach_px` whose depth differs by no more than `near_m` (any, where one of the
  /// two is NaN), weighted by 1 - (distance / reach)^2.
  Sum around(const cv::Point2f& px, float depth_m, float reach_px, float near_m) const {
    const float per_reach2 = 1 / (reach_px * reach_px);
    Sum sum;
    if (by_place_.empty()) return sum;
    grid_.ranges_around(px, reach_px, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        const Value& v = by_place_[e];
        const float dx = v.x - px.x, dy = v.y - px.y;
        float weight = std::max(0.0F, 1 - (dx * dx + dy * dy) * per_reach2);
        weight = std::abs(v.depth_m - depth_m) > near_m ? 0.0F : weight;
        sum.values += weight * v.value;
        sum.weights += weight;
      }
    });
    return sum;
  }

 private:
  struct Value {
    float x, y, depth_m, value;
    bool operator<(const Value& o) const {
      return std::tie(y, x, depth_m, value) < std::tie(o.y, o.x, o.depth_m, o.value);
    }
  };

  std::vector<cv::Point2f> places_;
  std::vector<Value> values_, by_place_;
  PointGrid grid_;
};

}  // namespace dynfilter
