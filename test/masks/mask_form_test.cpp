// SPDX-License-Identifier: MIT
#include "masks/mask_form.hpp"

#include <opencv2/core.hpp>

#include "doctest/doctest.h"

using namespace dynfilter::masks;

namespace mask_form_test {

TEST_CASE("names and polarity of each tool") {
  const cv::Mat moving = (cv::Mat_<std::uint8_t>(1, 2) << 0, 255);
  const auto check = [&](const char* tool, const char* file, int where_it_moves) {
    CAPTURE(tool);
    const MaskForm* form = mask_form(tool);
    REQUIRE(form != nullptr);
    CHECK(form->file_of("rgb/000001.jpg") == file);
    CHECK(form->image_of(moving).at<std::uint8_t>(0, 1) == where_it_moves);
    CHECK(form->image_of(moving).at<std::uint8_t>(0, 0) == 255 - where_it_moves);
  };
  check("colmap", "000001.jpg.png", 0);
  check("openmvg", "000001_mask.png", 0);
  check("nerfstudio", "000001.png", 0);
  check("droid", "000001.png", 0);
  check("plain", "000001.png", 255);
  CHECK(mask_form("metashape") == nullptr);
  CHECK(mask_forms().size() == 5);
}

TEST_CASE("an image with dots in its name keeps them") {
  CHECK(mask_form("plain")->file_of("1700.250000.png") == "1700.250000.png");
  CHECK(mask_form("colmap")->file_of("1700.250000.png") == "1700.250000.png.png");
}

}  // namespace mask_form_test
