// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "render/mesh.hpp"

namespace dynfilter::render {

/// The point of triangle a, b, c nearest to p (Ericson, Real-Time Collision Detection, 5.1.5).
Eigen::Vector3f nearest_on_triangle(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                                    const Eigen::Vector3f& b, const Eigen::Vector3f& c);

/// Distances to the triangles of models, using a tree of boxes.
/// A query takes some microseconds. Read-only after build().
class MeshDistance {
 public:
  struct Nearest {
    float distance_m = std::numeric_limits<float>::infinity();
    Eigen::Vector3f point{0, 0, 0};  ///< on the surface
  };

  void add(const Model& model);

  void build();

  std::size_t size() const { return triangles_.size(); }

  /// The nearest surface point closer than `within_m`; infinity if there is none.
  Nearest nearest(const Eigen::Vector3f& p, float within_m) const;

 private:
  struct Triangle {
    std::array<Eigen::Vector3f, 3> corner;
    Eigen::Vector3f middle() const { return (corner[0] + corner[1] + corner[2]) / 3; }
  };
  struct Node {
    Eigen::Vector3f low, high;
    std::uint32_t first = 0,
                  // A leaf's triangles; count 0: the children are the next node and `first`.
        count = 0;
  };
  static constexpr std::size_t kLeaf = 4;

  void split(std::size_t first, std::size_t last);

  static float distance_to_box(const Node& node, const Eigen::Vector3f& p) {
    return (p - p.cwiseMax(node.low).cwiseMin(node.high)).norm();
  }

  void visit(std::size_t at, const Eigen::Vector3f& p, Nearest& best, bool& found) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace dynfilter::render
