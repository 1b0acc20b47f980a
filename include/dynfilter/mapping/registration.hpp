// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <dynfilter/mapping/map_cloud.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_grid.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <optional>
#include <unordered_map>
#include <vector>

namespace dynfilter::mapping {

/// Aligns a keyframe's cloud with the map before fusion. DeS-SLAM (sec. 3.3) has a registration, but does not
/// specify it. This is point-to-plane ICP (Chen and Medioni 1992) with Cauchy weights. The plane of a map
/// voxel is fitted to its neighbours within two cells. Finds offsets of up to about two leaves.
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
  static constexpr double kMinInformation = 0.02;  ///< Of a pair, in its least certain direction.
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

  Eigen::Vector3d centroid(std::uint32_t i) const {
    const Voxel& v = map_->voxels()[i];
    return Eigen::Vector3d(voxel_units(v, 0), voxel_units(v, 1), voxel_units(v, 2)) * unit_m_;
  }
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

inline std::optional<Pose> MapRegistration::run(const VoxelMap& map, double unit_m,
                                                const std::vector<VoxelPoint>& cloud,
                                                const Pose& T_world_camera) {
  planes_.clear();
  map_ = &map;
  unit_m_ = unit_m;
  leaf_m_ = unit_m * std::ldexp(1.0, VoxelMap::kLeafBits + map.level());
  Eigen::Matrix3d R = T_world_camera.R();
  Eigen::Vector3d t = T_world_camera.t();
  double first_cost = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const Normal normal = pair(cloud, R, t);
    if (round == 0) first_cost = normal.cost;
    std::array<double, 6> step{};
    if (!solve(normal, step)) return std::nullopt;
    const Eigen::Vector3d turn(step[3], step[4], step[5]);
    const Eigen::Matrix3d dR = turn.norm() > 0
                                   ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                                   : Eigen::Matrix3d::Identity();
    R = dR * R;
    t = dR * (t - normal.centre) + normal.centre + Eigen::Vector3d(step[0], step[1], step[2]);
    if (!within_bounds(R, t, T_world_camera)) return std::nullopt;
    const double moved = std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2]), turn.norm()});
    if (moved < 1e-5) break;
  }
  if (!(pair(cloud, R, t).cost <= first_cost)) return std::nullopt;
  return Pose::from(Eigen::Quaterniond(R).normalized().toRotationMatrix(), t);
}

template <class F>
void MapRegistration::for_each_around(const Eigen::Vector3d& p, const F& f) const {
  std::array<std::int32_t, 3> cell;
  for (int a = 0; a < 3; ++a) {
    const double c = std::floor(p[a] / leaf_m_);
    if (!(std::abs(c) < VoxelKey::kOffset - kReach)) return;
    cell[static_cast<std::size_t>(a)] = static_cast<std::int32_t>(c);
  }
  for (int z = -kReach; z <= kReach; ++z)
    for (int y = -kReach; y <= kReach; ++y)
      for (int x = -kReach; x <= kReach; ++x) {
        const std::uint32_t i = map_->find(VoxelKey::pack(cell[0] + x, cell[1] + y, cell[2] + z));
        if (i != VoxelMap::kNone) f(i);
      }
}

inline const MapRegistration::Plane& MapRegistration::plane_of(std::uint32_t i) {
  const auto [at, is_new] = planes_.try_emplace(i);
  Plane& plane = at->second;
  if (!is_new) return plane;
  Eigen::Vector3d sum(0, 0, 0);
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double n = 0;
  const Eigen::Vector3d own = centroid(i);
  for_each_around(own, [&](std::uint32_t j) {
    const Eigen::Vector3d d = centroid(j) - own;
    sum += d;
    squares += d * d.transpose();
    ++n;
  });
  if (n < kPlaneVoxels) return plane;
  const Eigen::Vector3d mean = sum / n;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(squares / n - mean * mean.transpose());
  plane.flat = eigen.eigenvalues()[0] < 0.05 * eigen.eigenvalues()[1];
  plane.at = own + mean;
  plane.normal = eigen.eigenvectors().col(0);
  return plane;
}

inline MapRegistration::Normal MapRegistration::pair(const std::vector<VoxelPoint>& cloud,
                                                     const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Normal normal;
  pairs_.clear();
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kTried);
  for (std::size_t k = step / 2; k < cloud.size(); k += step) {
    ++normal.tried;
    const VoxelPoint& q = cloud[k];
    const Eigen::Vector3d p = R * Eigen::Vector3d(q.x, q.y, q.z) + t;
    std::uint32_t nearest = VoxelMap::kNone;
    double least = 1e300;
    for_each_around(p, [&](std::uint32_t i) {
      const double d2 = (centroid(i) - p).squaredNorm();
      if (d2 < least) least = d2, nearest = i;
    });
    if (nearest == VoxelMap::kNone) continue;
    const Plane& plane = plane_of(nearest);
    if (!plane.flat) continue;
    const double r_m = plane.normal.dot(p - plane.at), scaled = r_m / (0.5 * leaf_m_);
    pairs_.push_back({p, plane.normal, r_m, 1 / (1 + scaled * scaled)});
  }
  sum_up(normal);
  return normal;
}

inline void MapRegistration::sum_up(Normal& normal) const {
  normal.pairs = pairs_.size();
  for (const Pair& pair : pairs_) {
    normal.weight += pair.weight;
    normal.centre += pair.weight * pair.p;
  }
  if (!(normal.weight > 0)) return;
  normal.centre /= normal.weight;
  double size2 = 0, cost = 0;
  for (const Pair& pair : pairs_) {
    size2 += pair.weight * (pair.p - normal.centre).squaredNorm();
    cost -= std::log(pair.weight);
  }
  normal.size_m = std::max(1e-6, std::sqrt(size2 / normal.weight));
  normal.cost = cost / static_cast<double>(pairs_.size());
  for (const Pair& pair : pairs_) {
    const Eigen::Vector3d turn = (pair.p - normal.centre).cross(pair.normal) / normal.size_m;
    const std::array<double, 6> J{pair.normal[0], pair.normal[1], pair.normal[2], turn[0], turn[1], turn[2]};
    for (std::size_t r = 0; r < 6; ++r) {
      normal.b[r] -= pair.weight * J[r] * pair.r_m / normal.weight;
      for (std::size_t c = 0; c < 6; ++c) normal.A[6 * r + c] += pair.weight * J[r] * J[c] / normal.weight;
    }
  }
}

inline bool MapRegistration::solve(const Normal& normal, std::array<double, 6>& step) const {
  if (normal.pairs < static_cast<std::size_t>(RegistrationParams::kMinPoints) ||
      normal.pairs * 3 < normal.tried)
    return false;
  std::array<double, 36> variance{};
  if (!dynfilter::detail::invert_positive_definite(normal.A.data(), variance.data(), 6)) return false;
  for (std::size_t k = 0; k < 6; ++k)
    if (!(variance[7 * k] * kMinInformation < 1)) return false;
  std::array<double, 36> A = normal.A;
  step = normal.b;
  if (!dynfilter::detail::solve_positive_definite(A.data(), step.data(), 6)) return false;
  for (std::size_t k = 3; k < 6; ++k) step[k] /= normal.size_m;
  return true;
}

inline bool MapRegistration::within_bounds(const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
                                           const Pose& given) const {
  const double moved_m = (t - given.t()).norm();
  const double turned_rad = Eigen::AngleAxisd(R * given.R().transpose()).angle();
  return moved_m <= params_.max_correction_m &&
         turned_rad <= RegistrationParams::kMaxCorrection_deg * 3.14159265 / 180;
}

}  // namespace dynfilter::mapping
