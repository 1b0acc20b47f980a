// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/frame_view.hpp>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "masks/run_mask.hpp"

namespace dynfilter::masks {

/// One object that a detector found in one image.
struct Instance {
  RunMask mask;
  std::string class_name;
};

/// What a detector says about one image. Images that it does not make are empty.
struct Semantics {
  const std::vector<Detection>* detections = nullptr;  ///< null: no answer
  cv::Mat labels;                                      ///< CV_8UC1 of any size, 0: background
  cv::Mat depth;                                       ///< of the image's size, CV_16UC1 or CV_32FC1
  double depth_unit_m = 1;
};

/// The instances of one image, in the order of the detections.
/// A box takes the detector's own instance mask, else the labelled pixels in it, else the object that the
/// depth image shows in it. A box with none of these is left out.
/// Without boxes each connected region of one label is an instance.
std::vector<Instance> instances_of(const Semantics& seen, cv::Size image);

}  // namespace dynfilter::masks
