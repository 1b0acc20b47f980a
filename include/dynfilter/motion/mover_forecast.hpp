// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <dynfilter/motion/static_miss.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// The evidence of the last frame at the places where its surfaces are now: what moved goes on as it did.
///
/// A car at 8 m, seen at 10 Hz, jumps 40 px and grows by a fifth. Most of its features match nothing, but lie
/// where the car was bound to be. Each feature with a depth is carried on by the camera's motion, a mover by
/// the velocity of its object, too. It is the median of those measured in its cell of space, else of those
/// that were forecast there. O(n log n), about 50 us for 1000 features.
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
    const auto kept = static_cast<float>(portable::exp(-elapsed_s / kMemory_s));
    const PointMotion to_now(T_now_then);
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    px_.clear();
    depths_m_.clear();
    for (Seen& feature : carried_) {
      feature.point_m = to_now(feature.point_m + static_cast<float>(elapsed_s) * feature.velocity_mps);
      feature.velocity_mps = to_now.turn(feature.velocity_mps);
      feature.evidence *= kept;
      const cv::Point3f& q = feature.point_m;
      px_.push_back(q.z > static_cast<float>(StaticMissModel::kNearest_m) ? project(camera, q)
                                                                          : cv::Point2f(kNone, kNone));
      depths_m_.push_back(q.z);
    }
    places_.build(px_, depths_m_, kReach_px);
    places_.lay_out(
        field_, [&](std::size_t i) { return carried_[i].evidence; }, [](std::size_t) { return 1.0F; });
  }

  /// Mean evidence of motion that is expected at an undistorted pixel [nats], 0 where nothing is. Depths
  /// differ by at most `near_m`. NaN: a feature without depth, which may lie on what is behind.
  float evidence(const cv::Point2f& px, float depth_m, float near_m) const {
    const bool blind = std::isnan(depth_m);
    const NeighbourPlaces::Sum sum =
        places_.around(field_, px, depth_m, blind ? kBlindReach_px : kReach_px, near_m);
    return sum.weights > 0 ? (blind ? kBlindTrust : 1.0F) * sum.values / sum.weights : 0.0F;
  }

  static constexpr double kNear_m = 1;  ///< of depths on one object, besides their noise

 private:
  static constexpr double kMemory_s = 0.45;                    ///< cars pass in a second
  static constexpr float kReach_px = 40, kBlindReach_px = 25;  ///< a near car has few features
  static constexpr float kBlindTrust = 0.8F;                   ///< it may lie on what is behind
  static constexpr float kCell_m = 2;                          ///< a car's width

  /// Median velocities of movers by cells of space.
  class Cells {
   public:
    void build(const std::vector<Seen>& seen) {
      movers_.clear();
      for (const Seen& feature : seen)
        if (feature.moves && finite(feature.velocity_mps))
          movers_.push_back({cell(feature.point_m), feature.velocity_mps});
      std::sort(movers_.begin(), movers_.end(),
                [](const Entry& a, const Entry& b) { return a.cell < b.cell; });
      medians_.clear();
      for (std::size_t begin = 0, end = 0; begin < movers_.size(); begin = end) {
        while (end < movers_.size() && movers_[end].cell == movers_[begin].cell) ++end;
        if (end - begin >= kLeast) medians_.push_back({movers_[begin].cell, median(begin, end)});
      }
    }
    const cv::Point3f* find(const cv::Point3f& point_m) const {
      const Cell at = cell(point_m);
      const auto found = std::lower_bound(medians_.begin(), medians_.end(), at,
                                          [](const Entry& a, const Cell& b) { return a.cell < b; });
      return found != medians_.end() && found->cell == at ? &found->velocity_mps : nullptr;
    }

   private:
    static constexpr std::size_t kLeast = 2;  ///< one may be a mismatch
    using Cell = std::array<int, 3>;
    struct Entry {
      Cell cell;
      cv::Point3f velocity_mps;
    };
    static Cell cell(const cv::Point3f& point_m) {
      return {cvFloor(point_m.x / kCell_m), cvFloor(point_m.y / kCell_m), cvFloor(point_m.z / kCell_m)};
    }
    static bool finite(const cv::Point3f& v) {
      return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    }
    cv::Point3f median(std::size_t begin, std::size_t end) {
      const auto along = [&](float cv::Point3f::*axis) {
        axis_mps_.clear();
        for (std::size_t m = begin; m < end; ++m) axis_mps_.push_back(movers_[m].velocity_mps.*axis);
        return median_in_place(axis_mps_);
      };
      return {along(&cv::Point3f::x), along(&cv::Point3f::y), along(&cv::Point3f::z)};
    }
    std::vector<Entry> movers_, medians_;  ///< sorted by cell
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
