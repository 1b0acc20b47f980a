// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace dynfilter::masks {

/// How a tool wants its masks. docs/how-to/masks.md says where each tool states it.
struct MaskForm {
  std::string tool;             ///< as `--for` names it
  bool zero_masks = true;       ///< 0 on what is masked and 255 elsewhere, or the reverse
  std::string suffix;           ///< behind the image's name
  bool with_extension = false;  ///< the image's name keeps its own extension

  /// Name of the mask of an image. `image`: its file name, possibly with folders, which are left out.
  std::string file_of(const std::string& image) const;
  /// `moving`: CV_8UC1, 255 on what is to be masked.
  cv::Mat image_of(const cv::Mat& moving) const;
};

/// All forms, in the order of the help.
const std::vector<MaskForm>& mask_forms();

/// Null for an unknown tool.
const MaskForm* mask_form(const std::string& tool);

}  // namespace dynfilter::masks
