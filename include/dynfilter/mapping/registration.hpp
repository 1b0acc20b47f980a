// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_grid.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <optional>
#include <unordered_map>
#include <vector>

namespace dynfilter::mapping {

/// Aligns a keyframe's cloud with the map before fusion.
/// DeS-SLAM (sec. 3.3) has a registration, but does not specify it.
/// This is point-to-plane ICP (Chen and Medioni 1992) with Cauchy weights.
/// The plane of a map voxel is fitted to its neighbours within two cells.
/// Finds offsets of up to about two leaves.
///
/// Returns nothing in these cases:
///  - fewer than `min_points` pairs, or than a third of the tested points;
///  - planes that leave a direction undetermined, such as one wall or a corridor;
///  - a correction above the limits;
///  - a fit that is not better.
/// Deterministic. Cost: about 2000 points with 125 look-ups each, a few times.
class MapRegistration {
 public:
  explicit MapRegistration(const RegistrationParams& params) : params_(params) {}

  /// `cloud`: camera frame; `unit_m`: quantum of the map. Returns the improved pose.
  std::optional<Pose> run(const VoxelMap& map, double unit_m, const std::vector<VoxelPoint>& cloud,
                          const Pose& T_world_camera);

 private:
  static constexpr int kMaxRounds = 30, kReach = 2;
  static constexpr std::size_t kTried = 2000, kPlaneVoxels = 6;
  static constexpr double kMinInformation = 0.02;  ///< of a pair, in its least certain direction
  struct Plane {
    bool flat = false;
    Eigen::Vector3d at{0, 0, 0}, normal{0, 0, 0};
  };
  struct Pair {
    Eigen::Vector3d p, normal;
    double r_m, weight;
  };
  struct Normal {
    std::array<double, 36> A{};
    std::array<double, 6> b{};
    Eigen::Vector3d centre{0, 0, 0};
    double size_m = 1, weight = 0, cost = 1e300;  ///< cost: mean of the robust loss
    std::size_t pairs = 0, tried = 0;
  };

  Eigen::Vector3d centroid(std::uint32_t i) const;
  template <class F>
  void for_each_around(const Eigen::Vector3d& p, const F& f) const;

  const Plane& plane_of(std::uint32_t i);

  Normal pair(const std::vector<VoxelPoint>& cloud, const Eigen::Matrix3d& R, const Eigen::Vector3d& t);
  /// Rotation is about the centre of the points and scaled by their distance.
  /// All six numbers are therefore in metres.
  void sum_up(Normal& normal) const;

  bool solve(const Normal& normal, std::array<double, 6>& step) const;
  bool within_bounds(const Eigen::Matrix3d& R, const Eigen::Vector3d& t, const Pose& given) const;

  RegistrationParams params_;
  const VoxelMap* map_ = nullptr;
  double unit_m_ = 1, leaf_m_ = 1;
  std::unordered_map<std::uint32_t, Plane> planes_;
  std::vector<Pair> pairs_;
};

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/registration-inl.hpp>
#endif
