// SPDX-License-Identifier: MIT
#include "render/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter::render {

void Model::finish() {
  for (Face& f : faces) {
    const Vertex &a = vertices[f.corner[0]], &b = vertices[f.corner[1]], &c = vertices[f.corner[2]];
    const Eigen::Vector3f outside = (c.position_m - a.position_m).cross(b.position_m - a.position_m);
    if (outside.dot(a.normal + b.normal + c.normal) < 0) std::swap(f.corner[1], f.corner[2]);
  }
  if (vertices.empty()) return;
  Eigen::Vector3f low = vertices[0].position_m, high = low;
  for (const Vertex& v : vertices) {
    low = low.cwiseMin(v.position_m);
    high = high.cwiseMax(v.position_m);
  }
  centre_m = (low + high) / 2;
  radius_m = (high - low).norm() / 2;
}

void add_rectangle(Model& model, const Rectangle& r, const Skin& skin, float cell_m, int instance) {
  if (skin.material == kNoSkin) return;
  const float width = r.right.norm(), height = r.down.norm();
  const int nu = std::max(1, static_cast<int>(std::ceil(width / cell_m)));
  const int nv = std::max(1, static_cast<int>(std::ceil(height / cell_m)));
  const Eigen::Vector3f normal = r.down.cross(r.right).normalized();
  const auto base = static_cast<std::uint32_t>(model.vertices.size());
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(nu),
                  v = static_cast<float>(j) / static_cast<float>(nv);
      Eigen::Vector2f uv(skin.window.x + u * skin.window.width, skin.window.y + v * skin.window.height);
      if (skin.tile_m > 0) uv = Eigen::Vector2f(u * width, v * height) / skin.tile_m;
      model.vertices.push_back({r.corner + u * r.right + v * r.down, normal, uv});
    }
  }
  const auto at = [&](int i, int j) { return base + static_cast<std::uint32_t>(j * (nu + 1) + i); };
  const auto material = static_cast<std::uint16_t>(skin.material),
             object = static_cast<std::uint16_t>(instance);
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      model.faces.push_back({{at(i, j), at(i + 1, j), at(i, j + 1)}, material, object});
      model.faces.push_back({{at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, material, object});
    }
  }
}

void add_box(Model& model, const Eigen::Isometry3f& frame, const Eigen::Vector3f& size_m, const BoxSkin& skin,
             float cell_m, int instance) {
  const Eigen::Vector3f h = size_m / 2;
  const Eigen::Vector3f x = frame.linear() * Eigen::Vector3f(size_m.x(), 0, 0);
  const Eigen::Vector3f y = frame.linear() * Eigen::Vector3f(0, size_m.y(), 0);
  const Eigen::Vector3f z = frame.linear() * Eigen::Vector3f(0, 0, size_m.z());
  const auto corner = [&](float sx, float sy, float sz) -> Eigen::Vector3f {
    return frame * Eigen::Vector3f(sx * h.x(), sy * h.y(), sz * h.z());
  };
  add_rectangle(model, {corner(-1, -1, 1), x, -z}, skin.front, cell_m, instance);
  add_rectangle(model, {corner(1, 1, 1), -x, -z}, skin.back, cell_m, instance);
  add_rectangle(model, {corner(-1, 1, 1), -y, -z}, skin.left, cell_m, instance);
  add_rectangle(model, {corner(1, -1, 1), y, -z}, skin.right, cell_m, instance);
  add_rectangle(model, {corner(-1, 1, 1), x, -y}, skin.top, cell_m, instance);
  add_rectangle(model, {corner(-1, -1, -1), x, y}, skin.bottom, cell_m, instance);
}

Eigen::Vector3f loft_point(const Ring& ring, float u, float exponent) {
  const float angle = static_cast<float>(2 * CV_PI) * u;
  const float s = std::sin(angle), c = -std::cos(angle);
  const float k =
      std::pow(std::pow(std::abs(s), exponent) + std::pow(std::abs(c), exponent), -1.0F / exponent);
  return {ring.centre_x + ring.radius_x * s * k, ring.centre_y + ring.radius_y * c * k, ring.z};
}

void add_loft(Model& model, const Eigen::Isometry3f& frame, const std::vector<Ring>& rings,
              const Wrap& wrap) {
  const int rows = static_cast<int>(rings.size()), n = wrap.segments;
  const auto base = static_cast<std::uint32_t>(model.vertices.size());
  for (int j = 0; j < rows; ++j) {
    const auto ring_at = [&](int row) -> const Ring& { return rings[static_cast<std::size_t>(row)]; };
    const Ring &ring = ring_at(j), &above = ring_at(std::max(0, j - 1)),
               &below = ring_at(std::min(rows - 1, j + 1));
    for (int i = 0; i <= n; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(n);
      const Eigen::Vector3f around =
          loft_point(ring, u + 0.01F, wrap.exponent) - loft_point(ring, u - 0.01F, wrap.exponent);
      const Eigen::Vector3f along = loft_point(above, u, wrap.exponent) - loft_point(below, u, wrap.exponent);
      Eigen::Vector3f normal = along.cross(around);
      const Eigen::Vector3f p = loft_point(ring, u, wrap.exponent);
      const Eigen::Vector3f out = p - Eigen::Vector3f(ring.centre_x, ring.centre_y, ring.z);
      if (normal.norm() < 1e-9F) normal = out;
      if (normal.dot(out) < 0) normal = -normal;
      const float v = static_cast<float>(j) / static_cast<float>(rows - 1);
      model.vertices.push_back(
          {frame * p, frame.linear() * normal.normalized(), {u * wrap.around, v * wrap.along}});
    }
  }
  const auto at = [&](int i, int j) { return base + static_cast<std::uint32_t>(j * (n + 1) + i); };
  const auto material = static_cast<std::uint16_t>(wrap.material),
             object = static_cast<std::uint16_t>(wrap.instance);
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i < n; ++i) {
      model.faces.push_back({{at(i, j), at(i + 1, j), at(i, j + 1)}, material, object});
      model.faces.push_back({{at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, material, object});
    }
  }
}

std::vector<Ring> ellipsoid_rings(const Eigen::Vector3f& centre, const Eigen::Vector3f& radii, int count) {
  std::vector<Ring> rings;
  for (int i = 0; i < count; ++i) {
    const float angle = static_cast<float>(CV_PI) * static_cast<float>(i) / static_cast<float>(count - 1);
    const float s = std::max(0.002F, std::sin(angle));
    rings.push_back(
        {centre.z() + radii.z() * std::cos(angle), centre.x(), centre.y(), radii.x() * s, radii.y() * s});
  }
  return rings;
}

}  // namespace dynfilter::render
