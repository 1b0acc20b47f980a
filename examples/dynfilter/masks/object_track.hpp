// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/votes.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "masks/run_mask.hpp"

namespace dynfilter::masks {

/// A feature of an image and what the pipeline decided about it.
struct JudgedFeature {
  cv::KeyPoint keypoint;
  Vote decision = Vote::Unknown;
};

/// One object in one image.
struct Sighting {
  std::size_t frame = 0;
  double time_s = 0;
  RunMask mask;
  bool carried = false;         ///< the detector missed it here: the mask is carried from the image before
  int dynamic = 0, judged = 0;  ///< features on it
};

/// One object through the clip, by time.
struct ObjectTrack {
  std::string class_name;
  std::vector<Sighting> sightings;
};

}  // namespace dynfilter::masks
