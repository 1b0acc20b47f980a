// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// One detected object, in pixels of the distorted image.
struct Detection {
  cv::Rect2f box;          ///< x and y of the top left corner, width, height [px]
  int class_id = -1;       ///< class number of the detector; -1: unknown
  std::string class_name;  ///< e.g. "person"; filters select classes by name
  float score = 1.0F;      ///< confidence in [0, 1]
  int track_id = -1;       ///< -1: not tracked
  cv::Mat mask;            ///< CV_8UC1 instance mask of the whole image, 0: outside; empty: no mask
};

/// Names of the classes that move by themselves, as common detectors spell them.
inline std::vector<std::string> moving_classes() {
  return {"person",   "bird",  "cat",   "dog",     "horse",     "sheep",    "cow",
          "elephant", "bear",  "zebra", "giraffe", "car",       "bicycle",  "motorcycle",
          "bus",      "train", "truck", "boat",    "aeroplane", "airplane", "motorbike"};
}

}  // namespace dynfilter
