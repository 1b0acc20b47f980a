// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "io/sequence.hpp"
#include "mask_run.hpp"
#include "masks/mask_form.hpp"
#include "results_folder.hpp"
#include "text/json.hpp"

namespace dynfilter::command {

Json to_json(const MaskSummary& summary);

/// Writes masks/, overlay/, masks.json and, for nerfstudio, transforms.json. All appear at the end, or none.
class MaskOutput {
 public:
  /// Throws IoError if the folder has other results and may not replace them.
  MaskOutput(const RunOptions& options, const masks::MaskForm& form);

  /// True if frame `k` of the played ones gets a picture. There are about fifty.
  bool wants_picture(std::size_t k) const { return k % every_ == 0; }
  void set_frames(std::size_t frames);

  /// `image`: file name of the image. `moving`, `standing`: nonzero on objects that are masked, and on those
  /// that are not. `colour` is used if wants_picture().
  void add(std::size_t k, const std::string& image, const cv::Mat& moving, const cv::Mat& standing,
           const cv::Mat& colour);

  /// An image of a video, which has no files.
  void add_image(const std::string& image, const cv::Mat& colour);
  static constexpr const char* kImages = "images";  ///< their folder

  void finish(const io::Sequence& sequence, const std::vector<std::size_t>& order,
              const MaskSummary& summary);

 private:
  void write_image(const std::string& name, const cv::Mat& image) const;
  void add_transforms(const io::Sequence& sequence, const std::vector<std::size_t>& order) const;

  masks::MaskForm form_;
  ResultsFolder folder_;
  std::size_t every_ = 1;
};

}  // namespace dynfilter::command
