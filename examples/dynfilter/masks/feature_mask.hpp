// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/hosts/masked_image.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "masks/object_track.hpp"

namespace dynfilter::masks {

/// The depth image of a frame; empty: none.
struct DepthImage {
  cv::Mat image;  ///< CV_16UC1 or CV_32FC1, of the colour image's size
  double unit_m = 1;
};

/// A mask from rejected features alone: discs around them, and the triangles between neighbours that are all
/// rejected. With depth it is cut to what is as far away as the nearest rejected feature.
/// Buffers are kept.
class FeatureMask {
 public:
  explicit FeatureMask(cv::Size size);

  /// CV_8UC1, 255 on what moves. Valid until the next call.
  const cv::Mat& draw(const std::vector<JudgedFeature>& features, const DepthImage& depth);

 private:
  void split(const std::vector<JudgedFeature>& features);
  void find_groups();
  bool rejected(std::size_t i) const;
  const cv::Mat& seeds_of(Vote decision);
  void leave_to_kept();
  void keep_surface(const DepthImage& depth);

  cv::Size size_;
  double scale_;  ///< of lengths, against an image of 640x480
  MaskedImage discs_;
  std::vector<cv::KeyPoint> keypoints_;  ///< judged ones
  Verdict verdict_;
  std::vector<std::array<cv::Point, 3>> triangles_;  ///< between members of one group
  cv::Mat mask_, seeds_, distance_px_, nearest_;
};

}  // namespace dynfilter::masks
