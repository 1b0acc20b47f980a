// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <dynfilter/motion/static_miss.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// The evidence of the last frame at the places where its surfaces are now: what moved goes on as it did.
///
/// A car at 8 m, seen at 10 Hz, jumps 40 px and grows by a fifth. Most of its features match nothing, but lie
/// where the car was bound to be. So do those of an arm that is blurred. Each feature with a depth is carried
/// on by the camera's motion, a mover by the velocity of its object, too. It is the median of those measured
/// in its cell of space, else of those that were forecast there. O(n log n), about 50 us for 1000 features.
class MoverForecast {
 public:
  /// A feature of this frame. Points and velocities are in this camera's frame.
  struct Seen {
    cv::Point3f point_m;
    cv::Point3f velocity_mps;  ///< against the background; NaN: not measured
    float evidence = 0;        ///< of motion [nats]
    bool moves = false;
  };

  /// Nothing is expected.
  void clear() {
    carried_.clear();
    px_.clear();
    places_.clear();
  }

  /// Replaces what was known. Features that do not move count as standing still.
  void learn(const std::vector<Seen>& seen) {
    static const cv::Point3f kRest(0, 0, 0);
    measured_.build(seen);
    before_.build(carried_);
    carried_.clear();
    for (const Seen& feature : seen) {
      const cv::Point3f* velocity_mps = &kRest;
      if (feature.moves) velocity_mps = measured_.find(feature.point_m);
      if (velocity_mps == nullptr) velocity_mps = before_.find(feature.point_m);
      if (velocity_mps == nullptr) continue;
      carried_.push_back({feature.point_m, *velocity_mps, feature.evidence, feature.moves});
    }
  }

  /// Carries all of it into the next frame. `T_now_then`: from the last camera to this one.
  void advance(const Pose& T_now_then, const Camera& camera, double elapsed_s) {
    const PointMotion to_now(T_now_then);
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    px_.clear();
    depths_m_.clear();
    for (Seen& feature : carried_) {
      feature.point_m = to_now(feature.point_m + static_cast<float>(elapsed_s) * feature.velocity_mps);
      feature.velocity_mps = to_now.turn(feature.velocity_mps);
      const cv::Point3f& q = feature.point_m;
      px_.push_back(q.z > static_cast<float>(StaticMissModel::kNearest_m) ? project(camera, q)
                                                                          : cv::Point2f(kNone, kNone));
      depths_m_.push_back(q.z);
    }
    places_.build(px_, depths_m_, kReach_px / 2);
    places_.lay_out(
        field_, [&](std::size_t i) { return carried_[i].evidence; }, [](std::size_t) { return 1.0F; });
  }

  /// Whether anything is known of the last frame.
  bool expects() const { return !px_.empty(); }
  /// Mean evidence of motion that is expected at an undistorted pixel [nats], 0 where nothing is. Depths
  /// differ by at most `near_m`. NaN: a feature without depth, which may lie on what is behind.
  float evidence(const cv::Point2f& px, float depth_m, float near_m) const {
    const bool blind = std::isnan(depth_m);
    const NeighbourPlaces::Sum sum =
        places_.around(field_, px, depth_m, blind ? kBlindReach_px : kReach_px, near_m);
    return sum.weights > 0 ? (blind ? kBlindTrust : 1.0F) * sum.values / sum.weights : 0.0F;
  }

  static constexpr double kNearShare = 0.15;  ///< of a depth, by which those on one object differ

 private:
  static constexpr float kReach_px = 40, kBlindReach_px = 25;  ///< a near car has few features
  static constexpr float kBlindTrust = 0.8F;                   ///< it may lie on what is behind
  static constexpr float kCell_m = 2;                          ///< a car's width

  /// Median velocities of movers by cells of space.
  class Cells {
   public:
    void build(const std::vector<Seen>& seen) {
      movers_.clear();
      for (std::size_t i = 0; i < seen.size(); ++i)
        if (seen[i].moves && finite(seen[i].velocity_mps)) movers_.push_back({cell(seen[i].point_m), i});
      std::sort(movers_.begin(), movers_.end());
      medians_.clear();
      for (std::size_t begin = 0, end = 0; begin < movers_.size(); begin = end) {
        while (end < movers_.size() && movers_[end].first == movers_[begin].first) ++end;
        if (end - begin >= kLeast) medians_.push_back({movers_[begin].first, median(seen, begin, end)});
      }
    }
    const cv::Point3f* find(const cv::Point3f& point_m) const {
      const std::int64_t at = cell(point_m);
      const auto found = std::lower_bound(medians_.begin(), medians_.end(), at,
                                          [](const auto& a, std::int64_t b) { return a.first < b; });
      return found != medians_.end() && found->first == at ? &found->second : nullptr;
    }

   private:
    static constexpr std::size_t kLeast = 2;        ///< one may be a mismatch
    static constexpr std::int64_t kMost = 1 << 19;  ///< along an axis: farther ones share a cell
    static std::int64_t along(float m) {
      return std::clamp<std::int64_t>(cvFloor(m / kCell_m), -kMost, kMost - 1) + kMost;
    }
    static std::int64_t cell(const cv::Point3f& point_m) {
      return (along(point_m.x) * 2 * kMost + along(point_m.y)) * 2 * kMost + along(point_m.z);
    }
    static bool finite(const cv::Point3f& v) {
      return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    }
    cv::Point3f median(const std::vector<Seen>& seen, std::size_t begin, std::size_t end) {
      const auto along = [&](float cv::Point3f::*axis) {
        axis_mps_.clear();
        for (std::size_t m = begin; m < end; ++m)
          axis_mps_.push_back(seen[movers_[m].second].velocity_mps.*axis);
        return median_in_place(axis_mps_);
      };
      return {along(&cv::Point3f::x), along(&cv::Point3f::y), along(&cv::Point3f::z)};
    }
    std::vector<std::pair<std::int64_t, std::size_t>> movers_;  ///< cells and features, sorted
    std::vector<std::pair<std::int64_t, cv::Point3f>> medians_;
    std::vector<float> axis_mps_;
  };

  std::vector<Seen> carried_;
  Cells measured_, before_;
  std::vector<cv::Point2f> px_;
  std::vector<float> depths_m_;
  NeighbourPlaces places_;
  NeighbourPlaces::Field field_;
};

}  // namespace dynfilter
