// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/random.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "render/paint.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// Pictures for walls and furniture, painted from a seed. Each returns CV_8UC3.
namespace picture {

cv::Mat plaster(Random& r, const cv::Scalar& colour, double roughness);

cv::Mat wood(Random& r, const cv::Scalar& dark, const cv::Scalar& light);

cv::Mat parquet(Random& r);

cv::Mat carpet(Random& r);

cv::Mat ceiling_tile(Random& r);

cv::Mat landscape(Random& r, cv::Size size);

cv::Mat window_view(Random& r);

void paint_shapes(cv::Mat& out, Random& r, int count);

cv::Mat art_poster(Random& r);

cv::Mat paper_poster(Random& r);

cv::Mat whiteboard(Random& r);

/// Book backs side by side: kBooks columns of equal width.
constexpr int kBooks = 32;
cv::Mat book_backs(Random& r);

cv::Mat book_cover(Random& r);

inline cv::Mat page_edges(Random& r) {
  return ramp(fractal_noise({128, 64}, {2, 32}, 2, 0.6, r), bgr(176, 166, 146), bgr(236, 228, 210), 1.6);
}

cv::Mat screen(Random& r);

cv::Mat keyboard(Random& r);

cv::Mat paper_sheet(Random& r);

cv::Mat cardboard(Random& r);

cv::Mat fabric(Random& r, const cv::Scalar& colour);

inline cv::Mat felt(Random& r, const cv::Scalar& colour) {
  return ramp(fractal_noise({256, 256}, {5, 5}, 6, 0.9, r), colour * 0.78, colour * 1.2, 1.5);
}

cv::Mat leaf(Random& r);

cv::Mat drawers(Random& r, const cv::Scalar& colour);

cv::Mat door(Random& r);

/// One colour with straight joints, `wide_px` and `high_px` apart in a picture of 512 px; 0: none that way.
cv::Mat joints(const cv::Scalar& colour, const cv::Scalar& joint, int wide_px, int high_px);

}  // namespace picture

/// What is to be seen in a room.
enum class RoomLook {
  Furnished,
  Plain,  ///< almost no texture for a corner detector
  Edges   ///< long straight edges: tile joints, panels, blinds; as plain otherwise
};

/// All materials of a room.
struct RoomMaterials {
  int wall, partition, floor, ceiling, light_panel, wood_light, wood_dark, metal, black, white, whiteboard,
      book_backs, pages, keyboard, cardboard, chair_fabric, leaf, pot, drawers, door, mug, radiator;
  std::vector<int> windows, posters, screens, covers, papers;

  RoomMaterials(MaterialSet& set, Random& r, RoomLook look);

 private:
  void set_edges(MaterialSet& set, Random& r);
};

}  // namespace dynfilter::render
