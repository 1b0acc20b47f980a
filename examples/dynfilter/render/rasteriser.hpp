// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "render/mesh.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// Rows `first` to `last` of an image, both included.
struct RowRange {
  int first = 0, last = -1;
};

/// Output of the rasteriser at each pixel's centre.
struct GeometryImage {
  cv::Mat colour;    ///< CV_8UC3
  cv::Mat depth_m;   ///< CV_32FC1, exact; 0: no surface
  cv::Mat item;      ///< CV_16UC1, the item number given to draw()
  cv::Mat instance;  ///< CV_16UC1, detectable object; 0: none
  cv::Mat material;  ///< CV_16UC1
  cv::Mat facing;    ///< CV_32FC1, cosine between the viewing ray and the surface normal

  void create(cv::Size size);
};

/// Z-buffer rasteriser with four samples per pixel at silhouettes and one texture look-up per visible
/// triangle.
/// Edge functions and attributes are affine in the image (Olano, Greer, "Triangle scan conversion using 2D
/// homogeneous coordinates", 1997).
/// It therefore needs no clipping and is perspective-correct.
class Rasteriser {
 public:
  explicit Rasteriser(const Camera& camera);

  void begin() { begin({0, camera_.height_px - 1}); }

  /// Draws only these rows.
  void begin(RowRange rows);

  /// `shades`: one BGR factor per vertex instead of the model's own.
  void draw(const Model& model, const Eigen::Isometry3f& T_camera_model, int item,
            const std::vector<Eigen::Vector3f>* shades = nullptr);

  /// Colours every pixel from the triangles drawn since begin().
  void resolve(const MaterialSet& set, GeometryImage& out) const;

  /// The same without geometry: CV_8UC3. Rows that were not drawn remain unchanged.
  void resolve_colour(const MaterialSet& set, cv::Mat& out) const;

 private:
  static constexpr float kNear = 0.05F;

  struct Affine {
    float a = 0, b = 0, c = 0;
    float operator()(float x, float y) const { return a * x + b * y + c; }
  };
  using Edge = std::array<double, 3>;

  struct Triangle {
    float x0 = 0, y0 = 0;      // origin of the affine functions, px
    Affine q, u, v, shade[3];  // 1/z, and attribute/z
    std::uint16_t item = 0, material = 0, instance = 0;
  };

  int top_px() const { return std::max(0, rows_.first - 1); }
  int bottom_px() const { return std::min(camera_.height_px, rows_.last + 2); }

  bool sphere_visible(const Eigen::Vector3f& centre, float radius) const;

  /// Coefficients on (x, y, 1) in pixels of (a x b) . ray.
  /// Swapping a and b changes the sign exactly, so there are no cracks.
  Edge edge(const Eigen::Vector3f& a, const Eigen::Vector3f& b) const;

  struct Bounds {
    int x0, y0, x1, y1;  // samples, inclusive
  };

  Bounds bounds(const Eigen::Vector3f* corner[3]) const;

  void draw_face(const Model& model, const Face& face, int item, const std::vector<Eigen::Vector3f>* shades);

  Triangle set_up(const Model& model, const Face& face, int item, const std::vector<Eigen::Vector3f>* shades,
                  const Edge (&edges)[3], double det, const Bounds& box) const;

  void fill(const Edge (&edges)[3], double det, const Bounds& box, std::uint32_t index);

  void fill_span(int sy, int first, int last, const double (&q)[3], double y, std::uint32_t index);

  cv::Vec3f colour(const MaterialSet& set, const Triangle& t, float x, float y) const;

  using Samples = std::array<std::uint32_t, 4>;  // triangles

  Samples samples(int x, int y) const;
  std::size_t stride() const { return static_cast<std::size_t>(wide_); }
  std::size_t first_sample(int x, int y) const {
    return static_cast<std::size_t>(2 * y) * stride() + static_cast<std::size_t>(2 * x);
  }

  void resolve_pixel(const MaterialSet& set, int x, int y, GeometryImage& out) const;

  cv::Vec3b pixel_colour(const MaterialSet& set, const Samples& ids, int x, int y) const;

  /// The triangle that covers most samples. The closest one wins a tie.
  const Triangle& front(const Samples& ids, std::size_t at) const;

  void write_geometry(const Triangle& t, int x, int y, GeometryImage& out) const;

  Camera camera_;
  RowRange rows_;
  int wide_, high_;  // samples: two per pixel and axis
  std::vector<float> nearness_;
  std::vector<std::uint32_t> triangle_;
  std::vector<Triangle> triangles_;  // [0]: no triangle
  std::vector<Eigen::Vector3f> in_camera_;
};

}  // namespace dynfilter::render
