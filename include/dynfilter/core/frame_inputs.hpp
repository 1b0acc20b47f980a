// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <dynfilter/core/frame_view.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

/// For those who read a FrameView: what its boxes may show, and who owns its images.
namespace dynfilter {

/// Names of the classes that move by themselves, as common detectors spell them.
inline std::vector<std::string> moving_classes() {
  return {"person",   "bird",  "cat",   "dog",     "horse",     "sheep",    "cow",
          "elephant", "bear",  "zebra", "giraffe", "car",       "bicycle",  "motorcycle",
          "bus",      "train", "truck", "boat",    "aeroplane", "airplane", "motorbike"};
}

/// True if this cv::Mat alone refers to its memory. False for an image around a buffer of the caller.
inline bool has_sole_owner(const cv::Mat& image) {
  return image.u != nullptr && image.u->refcount == 1;
}

/// Copies an image that is kept beyond the call. Does not write to memory that something else refers to.
/// Allocates only for another size or type.
inline void keep_copy(const cv::Mat& image, cv::Mat& kept) {
  if (!has_sole_owner(kept)) kept.release();
  image.copyTo(kept);
}

/// Copies the pixels of an image unless nothing else refers to them.
inline void own_pixels(cv::Mat& image) {
  if (!image.empty() && !has_sole_owner(image)) image = image.clone();
}

/// True if depths come from the right image.
inline bool is_stereo(const FrameView& frame) {
  return !(frame.right_u_px.empty() && frame.right_grey.empty()) && frame.camera &&
         frame.camera->baseline_fx_px_m > 0;
}

/// False for NaN, negative and infinite columns of FrameView::right_u_px.
inline bool valid_right(float right_u_px) {
  return right_u_px >= 0 && std::isfinite(right_u_px);
}

}  // namespace dynfilter
