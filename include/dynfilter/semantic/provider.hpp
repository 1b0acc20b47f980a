// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/detection.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

/// One image on its way to a provider. The pixels are good until infer() returns, in whatever thread: a
/// provider that keeps them longer keeps a copy.
struct SemanticImage {
  std::int64_t frame_id = -1;
  double timestamp_s = 0;
  cv::Mat pixels;           ///< CV_8UC3 (BGR) or CV_8UC1
  cv::Mat depth;            ///< CV_32FC1 or CV_16UC1, same size as `pixels`; empty: none. Few providers look
  double depth_unit_m = 1;  ///< metres per unit of `depth`
};

/// What a provider found in one image. What it does not make stays unset; an empty list of detections says
/// that it looked and found nothing.
struct SemanticResult {
  std::int64_t frame_id = -1;  ///< the image it was computed on
  double timestamp_s = 0;
  std::optional<std::vector<Detection>> detections;  ///< pixels of that image
  std::optional<cv::Mat> labels;                     ///< CV_8UC1, 0 = background, of any size
};

/// Who makes boxes and masks: a network, a file, a program of its own. An object without globals, used by one
/// thread at a time. How late its results come, and what happens then, is not its concern.
class SemanticProvider {
 public:
  SemanticProvider() = default;
  SemanticProvider(const SemanticProvider&) = delete;
  SemanticProvider& operator=(const SemanticProvider&) = delete;
  virtual ~SemanticProvider() = default;

  virtual std::string name() const = 0;

  /// Looks at one image. Same image, same result. An empty optional: it has nothing to say about this image
  /// ("none came"). May throw any std::exception; whoever calls reports it and goes on without.
  virtual std::optional<SemanticResult> infer(const SemanticImage& image) = 0;
};

}  // namespace dynfilter
