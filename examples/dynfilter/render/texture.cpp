// SPDX-License-Identifier: MIT
#include "render/texture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter::render {

Texture::Texture(const cv::Mat& bgr) {
  cv::Mat level;
  cv::resize(bgr, level, {power_of_two(bgr.cols), power_of_two(bgr.rows)}, 0, 0, cv::INTER_AREA);
  cv::cvtColor(level, level, cv::COLOR_BGR2BGRA);
  levels_.push_back(level);
  while (level.cols > 1 && level.rows > 1) {
    cv::Mat half;
    cv::resize(level, half, {level.cols / 2, level.rows / 2}, 0, 0, cv::INTER_AREA);
    levels_.push_back(half);
    level = half;
  }
}

cv::Vec3f Texture::sample(float u, float v, float lod) const {
  const float top = static_cast<float>(levels_.size() - 1);
  const float level = std::min(std::max(lod, 0.0F), top);
  const int whole = static_cast<int>(level);
  const auto fine = static_cast<std::size_t>(whole);
  const float t = level - static_cast<float>(whole);
  const cv::Vec3f a = bilinear(levels_[fine], u, v);
  if (t < 0.02F || fine + 1 >= levels_.size()) return a;
  return a * (1.0F - t) + bilinear(levels_[fine + 1], u, v) * t;
}

inline int Texture::power_of_two(int n) {
  int p = 1;
  while (p < n) p *= 2;
  return p;
}

inline cv::Vec3f Texture::bilinear(const cv::Mat& level, float u, float v) {
  const float x = u * static_cast<float>(level.cols) - 0.5F, y = v * static_cast<float>(level.rows) - 0.5F;
  const float fx = std::floor(x), fy = std::floor(y);
  const float tx = x - fx, ty = y - fy;
  const int mask_x = level.cols - 1, mask_y = level.rows - 1;
  const int x0 = static_cast<int>(fx) & mask_x, x1 = (x0 + 1) & mask_x;
  const int y0 = static_cast<int>(fy) & mask_y, y1 = (y0 + 1) & mask_y;
  const auto* row0 = level.ptr<cv::Vec4b>(y0);
  const auto* row1 = level.ptr<cv::Vec4b>(y1);
  const float w11 = tx * ty, w01 = tx - w11, w10 = ty - w11, w00 = 1.0F - tx - w10;
  cv::Vec3f out;
  for (int c = 0; c < 3; ++c) {
    out[c] = w00 * static_cast<float>(row0[x0][c]) + w01 * static_cast<float>(row0[x1][c]) +
             w10 * static_cast<float>(row1[x0][c]) + w11 * static_cast<float>(row1[x1][c]);
  }
  return out;
}

int MaterialSet::add(const cv::Mat& bgr, float depth_dropout, bool glows) {
  textures.emplace_back(bgr);
  materials.push_back({static_cast<int>(textures.size()) - 1, depth_dropout, glows});
  return static_cast<int>(materials.size()) - 1;
}

}  // namespace dynfilter::render
