// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace dynfilter {

/// Features closer than half of the flow's window share its patch, and its error: one observation.
constexpr float kOnePatch_px = 8;

/// The features of a frame sorted by place, for sums of several values over the same neighbourhoods.
/// Results do not depend on the order of the features, down to the last bit.
/// Positions that are not finite are skipped.
class NeighbourPlaces {
 public:
  /// Weighted sum around a place.
  struct Sum {
    float values = 0, weights = 0;
  };
  /// Values at the features, in the order of the places. See lay_out().
  struct Field {
    std::vector<float> values, weights;
    std::vector<std::pair<float, float>> twins;  ///< scratch
  };

  /// One depth per position; NaN: unknown. `cell_px` is approximately the radius of most queries.
  /// About 25 us for 1000 features.
  void build(Span<const cv::Point2f> places_px, Span<const float> depths_m, float cell_px) {
    grid_.build(places_px, cell_px);
    order_ = grid_.entries();
    const auto key = [&](std::int32_t i) {
      const cv::Point2f& px = places_px[static_cast<std::size_t>(i)];
      const float depth_m = depths_m[static_cast<std::size_t>(i)];
      return std::make_tuple(px.y, px.x, std::isnan(depth_m) ? kUnknownFirst : depth_m);
    };
    // Sums of floats depend on their order, which must not be that of the features.
    grid_.for_each_cell([&](std::size_t begin, std::size_t end) {
      if (end - begin > 1)
        std::sort(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                  order_.begin() + static_cast<std::ptrdiff_t>(end),
                  [&](std::int32_t a, std::int32_t b) { return key(a) < key(b); });
    });
    for (std::vector<float>* column : {&x_, &y_, &depth_m_}) column->assign(order_.size() + kLanes, 0.0F);
    twins_.clear();
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const auto i = static_cast<std::size_t>(order_[k]);
      x_[k] = places_px[i].x, y_[k] = places_px[i].y, depth_m_[k] = depths_m[i];
      if (k > 0 && key(order_[k]) == key(order_[k - 1])) add_twin(k);
    }
  }
  void clear() {
    grid_.clear();
    order_.clear();
    twins_.clear();
  }

  /// Fills a field: value(i) and weight(i) of feature i. A weight of 0 leaves the feature out.
  template <class Value, class Weight>
  void lay_out(Field& field, const Value& value, const Weight& weight) const {
    field.values.assign(order_.size() + kLanes, 0.0F);
    field.weights.assign(order_.size() + kLanes, 0.0F);
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const auto i = static_cast<std::size_t>(order_[k]);
      field.weights[k] = weight(i);
      field.values[k] = field.weights[k] * value(i);
    }
    for (const auto& [begin, end] : twins_) order_twins(field, begin, end);
  }

  /// Sum over features within `reach_px` whose depth differs by at most `near_m`. Any depth counts if one of
  /// the two is NaN. Weights are multiplied by 1 - (distance / reach)^2.
  /// Features closer than `least_px` are left out.
  Sum around(const Field& field, const cv::Point2f& px, float depth_m, float reach_px, float near_m,
             float least_px = 0) const {
    Four values{}, weights{};
    near(px, depth_m, {reach_px, near_m, least_px}, [&](std::size_t e, const Four& weight) {
      values += weight * load(field.values, e);
      weights += weight * load(field.weights, e);
      return false;
    });
    return {detail::sum(values), detail::sum(weights)};
  }
  /// True if a feature with a weight is there. Stops at the first.
  bool any_around(const Field& field, const cv::Point2f& px, float depth_m, float reach_px,
                  float near_m) const {
    return near(px, depth_m, {reach_px, near_m, 0}, [&](std::size_t e, const Four& weight) {
      return detail::sum(weight * load(field.weights, e)) > 0;
    });
  }

 private:
  using Four = detail::Float4;
  static constexpr std::size_t kLanes = 4;
  static constexpr Four kLane{0, 1, 2, 3};
  /// Of a row of cells with more features than this, only every second four is read, or every third, ...: the
  /// sums are used as means. ORB-SLAM has 20 in a row, a dense front end 200.
  static constexpr std::size_t kMostInRow = 1024;
  static constexpr float kUnknownFirst = -1;  ///< where a feature without depth sorts

  struct Limits {
    float reach_px, near_m, least_px;
  };

  /// visit(entry, weights of four) until it returns true. Returns whether it did.
  template <class Visit>
  bool near(const cv::Point2f& px, float depth_m, const Limits& limits, const Visit& visit) const {
    const float per_reach2 = 1 / (limits.reach_px * limits.reach_px), near_m = limits.near_m;
    const float most = 1 - limits.least_px * limits.least_px * per_reach2;  // weight
    const Four none{};
    bool stopped = false;
    grid_.ranges_around(px, limits.reach_px, [&](std::size_t begin, std::size_t end) {
      const std::size_t step = kLanes * ((end - begin) / kMostInRow + 1);
      for (std::size_t e = begin; e < end && !stopped; e += step) {
        const Four dx = load(x_, e) - px.x, dy = load(y_, e) - px.y, deeper_m = load(depth_m_, e) - depth_m;
        Four weight = 1 - (dx * dx + dy * dy) * per_reach2;
        weight = weight > 0 ? weight : none;
        if (most < 1) weight = weight <= most ? weight : none;
        weight = (deeper_m > near_m || deeper_m < -near_m) ? none : weight;
        if (end - e < kLanes) weight = kLane < static_cast<float>(end - e) ? weight : none;
        stopped = visit(e, weight);
      }
    });
    return stopped;
  }

  void add_twin(std::size_t k) {
    if (!twins_.empty() && twins_.back().second == k)
      ++twins_.back().second;
    else
      twins_.emplace_back(k - 1, k + 1);
  }
  /// Features at one place have no order of their own: their values decide.
  static void order_twins(Field& field, std::size_t begin, std::size_t end) {
    std::vector<std::pair<float, float>>& twins = field.twins;
    twins.clear();
    for (std::size_t k = begin; k < end; ++k) twins.emplace_back(field.values[k], field.weights[k]);
    std::sort(twins.begin(), twins.end());
    for (std::size_t k = begin; k < end; ++k) std::tie(field.values[k], field.weights[k]) = twins[k - begin];
  }
  static Four load(const std::vector<float>& column, std::size_t at) {
    return detail::load_four(column.data() + at);
  }

  PointGrid grid_;
  std::vector<std::int32_t> order_;  ///< features by place
  std::vector<float> x_, y_, depth_m_;
  std::vector<std::pair<std::size_t, std::size_t>> twins_;  ///< ranges of order_ at one place
};

}  // namespace dynfilter
