// SPDX-License-Identifier: MIT
#include "render/mesh_distance.hpp"

#include <algorithm>
#include <utility>

namespace dynfilter::render {

Eigen::Vector3f nearest_on_triangle(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                                    const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Eigen::Vector3f bp = p - b;
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 - d3 > 0 ? d1 / (d1 - d3) : 0);
  const Eigen::Vector3f cp = p - c;
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 - d6 > 0 ? d2 / (d2 - d6) : 0);
  const float va = d3 * d6 - d5 * d4, along = d4 - d3, back = d5 - d6;
  if (va <= 0 && along >= 0 && back >= 0)
    return b + (c - b) * (along + back > 0 ? along / (along + back) : 0);
  const float sum = va + vb + vc;
  return sum > 0 ? Eigen::Vector3f(a + ab * (vb / sum) + ac * (vc / sum)) : a;
}

void MeshDistance::add(const Model& model) {
  for (const Face& face : model.faces) {
    Triangle t;
    for (std::size_t i = 0; i < 3; ++i) t.corner[i] = model.vertices[face.corner[i]].position_m;
    triangles_.push_back(t);
  }
}

void MeshDistance::build() {
  nodes_.clear();
  if (!triangles_.empty()) split(0, triangles_.size());
}

MeshDistance::Nearest MeshDistance::nearest(const Eigen::Vector3f& p, float within_m) const {
  Nearest best;
  best.distance_m = within_m;
  bool found = false;
  if (!nodes_.empty()) visit(0, p, best, found);
  if (!found) best.distance_m = std::numeric_limits<float>::infinity();
  return best;
}

inline void MeshDistance::split(std::size_t first, std::size_t last) {
  const std::size_t at = nodes_.size();
  nodes_.emplace_back();
  Eigen::Vector3f low = triangles_[first].corner[0], high = low, least = triangles_[first].middle(),
                  most = least;
  for (std::size_t i = first; i < last; ++i) {
    for (const Eigen::Vector3f& c : triangles_[i].corner) low = low.cwiseMin(c), high = high.cwiseMax(c);
    least = least.cwiseMin(triangles_[i].middle()), most = most.cwiseMax(triangles_[i].middle());
  }
  nodes_[at].low = low, nodes_[at].high = high;
  if (last - first <= kLeaf) {
    nodes_[at].first = static_cast<std::uint32_t>(first),
    nodes_[at].count = static_cast<std::uint32_t>(last - first);
    return;
  }
  int axis = 0;
  (most - least).maxCoeff(&axis);
  const std::size_t half = first + (last - first) / 2;
  const auto begin = triangles_.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(half),
                   begin + static_cast<std::ptrdiff_t>(last), [axis](const Triangle& a, const Triangle& b) {
                     return a.middle()[axis] < b.middle()[axis];
                   });
  split(first, half);
  nodes_[at].first = static_cast<std::uint32_t>(nodes_.size());
  split(half, last);
}

inline void MeshDistance::visit(std::size_t at, const Eigen::Vector3f& p, Nearest& best, bool& found) const {
  const Node& node = nodes_[at];
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const Triangle& t = triangles_[i];
    const Eigen::Vector3f q = nearest_on_triangle(p, t.corner[0], t.corner[1], t.corner[2]);
    const float d = (p - q).norm();
    if (d < best.distance_m) best = {d, q}, found = true;
  }
  if (node.count > 0) return;
  std::size_t near = at + 1, far = node.first;
  float to_near = distance_to_box(nodes_[near], p), to_far = distance_to_box(nodes_[far], p);
  if (to_far < to_near) std::swap(near, far), std::swap(to_near, to_far);
  if (to_near < best.distance_m) visit(near, p, best, found);
  if (to_far < best.distance_m) visit(far, p, best, found);
}

}  // namespace dynfilter::render
