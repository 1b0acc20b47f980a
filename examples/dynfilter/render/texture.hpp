// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace dynfilter::render {

/// A repeating picture with its mip levels (Williams, "Pyramidal parametrics", SIGGRAPH 1983).
class Texture {
 public:
  /// `bgr`: CV_8UC3; sides are rounded up to powers of two by resampling.
  explicit Texture(const cv::Mat& bgr);

  float width() const { return static_cast<float>(levels_[0].cols); }
  float height() const { return static_cast<float>(levels_[0].rows); }

  /// BGR in [0, 255] at (u, v), in units of the whole picture.
  /// `lod` is log2 of texels per pixel.
  cv::Vec3f sample(float u, float v, float lod) const;

 private:
  static int power_of_two(int n);

  static cv::Vec3f bilinear(const cv::Mat& level, float u, float v);

  std::vector<cv::Mat> levels_;  // CV_8UC4
};

/// Appearance of a surface, and its visibility to a structured-light camera.
struct Material {
  int texture = 0;
  /// Share of the surface without depth at 2 m because it is dark or shiny, [0, 1].
  float depth_dropout = 0;
  bool glows = false;  ///< windows, screens and lamps are not shaded
};

/// Textures and materials of one scene; models refer to materials by index.
struct MaterialSet {
  std::vector<Texture> textures;
  std::vector<Material> materials;

  int add(const cv::Mat& bgr, float depth_dropout = 0, bool glows = false);
};

}  // namespace dynfilter::render
