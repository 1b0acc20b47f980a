// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter::render {

struct Vertex {
  Eigen::Vector3f position_m, normal;
  Eigen::Vector2f uv;
  Eigen::Vector3f shade{1, 1, 1};  ///< BGR factors on the texture
};

struct Face {
  std::uint32_t corner[3];
  std::uint16_t material;
  std::uint16_t instance;  ///< number of the detectable object; 0: none
};

/// Triangles in one frame of reference, visible from outside only.
struct Model {
  std::vector<Vertex> vertices;
  std::vector<Face> faces;
  Eigen::Vector3f centre_m{0, 0, 0};
  float radius_m = 0;

  /// Orients every face towards its normals, and sets the bounding sphere.
  void finish();
};

constexpr int kNoSkin = -1;  ///< material of a side that is never visible

/// Covering of a surface: a material repeated every `tile_m` metres.
/// With tile_m = 0, the part `window` of its picture is stretched once over the surface.
struct Skin {
  int material = 0;
  float tile_m = 0;
  cv::Rect2f window{0, 0, 1, 1};
};

/// A rectangle viewed from its front. `corner` is the top left one, `right` and `down` are sides.
struct Rectangle {
  Eigen::Vector3f corner, right, down;
};

/// Adds a rectangle, divided into cells of at most `cell_m`, because shading is per vertex.
void add_rectangle(Model& model, const Rectangle& r, const Skin& skin, float cell_m = 10, int instance = 0);

/// Skins of a box. Its front is at -y of its frame, its top at +z.
struct BoxSkin {
  Skin front, back, left, right, top, bottom;
  static BoxSkin all(const Skin& s) { return {s, s, s, s, s, s}; }
};

/// A box with the centre and axes of `frame`.
void add_box(Model& model, const Eigen::Isometry3f& frame, const Eigen::Vector3f& size_m, const BoxSkin& skin,
             float cell_m = 10, int instance = 0);

/// One cross-section of a loft: at height z, centre and half-axes.
struct Ring {
  float z, centre_x, centre_y, radius_x, radius_y;
};

/// Wrapping of a loft: picture repeats around and along it, and number of corners around.
/// The exponent is that of the superellipse |x/rx|^e + |y/ry|^e = 1. 2 is an ellipse.
/// u = 0.5 is at +y of the frame.
struct Wrap {
  int material = 0;
  float around = 1, along = 1;
  int segments = 16;
  float exponent = 2;
  int instance = 0;
};

Eigen::Vector3f loft_point(const Ring& ring, float u, float exponent);

/// Skins a stack of rings, from top to bottom, with smooth normals.
/// Tiny first and last rings close it.
void add_loft(Model& model, const Eigen::Isometry3f& frame, const std::vector<Ring>& rings, const Wrap& wrap);

/// Rings of an ellipsoid around `centre`.
std::vector<Ring> ellipsoid_rings(const Eigen::Vector3f& centre, const Eigen::Vector3f& radii, int count = 9);

}  // namespace dynfilter::render
