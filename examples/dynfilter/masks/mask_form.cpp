// SPDX-License-Identifier: MIT
#include "masks/mask_form.hpp"

#include <filesystem>
#include <opencv2/core.hpp>

namespace dynfilter::masks {

std::string MaskForm::file_of(const std::string& image) const {
  const std::filesystem::path path(image);
  return (with_extension ? path.filename() : path.stem()).string() + suffix;
}

cv::Mat MaskForm::image_of(const cv::Mat& moving) const {
  cv::Mat mask;
  if (zero_masks)
    cv::bitwise_not(moving, mask);
  else
    moving.copyTo(mask);
  return mask;
}

const std::vector<MaskForm>& mask_forms() {
  static const std::vector<MaskForm> forms{
      {"colmap", true, ".png", true},      {"openmvg", true, "_mask.png", false},
      {"nerfstudio", true, ".png", false}, {"droid", true, ".png", false},
      {"plain", false, ".png", false},
  };
  return forms;
}

const MaskForm* mask_form(const std::string& tool) {
  for (const MaskForm& form : mask_forms())
    if (form.tool == tool) return &form;
  return nullptr;
}

}  // namespace dynfilter::masks
