// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

/// One image for a provider. The pixels are valid until infer() returns, in any thread.
/// A provider that keeps them longer must copy them.
struct SemanticImage {
  std::int64_t frame_id = -1;
  double timestamp_s = 0;
  cv::Mat pixels;  ///< CV_8UC3 (BGR) or CV_8UC1
  /// CV_32FC1 or CV_16UC1, same size as `pixels`; empty: no depth. Few providers use it.
  cv::Mat depth;
  double depth_unit_m = 1;  ///< metres per unit of `depth`
};

/// Result of a provider for one image. Outputs that the provider does not create remain unset.
/// An empty list of detections means that the provider found nothing.
struct SemanticResult {
  std::int64_t frame_id = -1;  ///< the image that it was computed on
  double timestamp_s = 0;
  std::optional<std::vector<Detection>> detections;  ///< in pixels of that image
  std::optional<cv::Mat> labels;                     ///< CV_8UC1 of any size, 0: background
};

/// A source of boxes and masks: a network, a file or a separate program.
/// It has no global state and is used by one thread at a time. The runner handles the delay of its results.
class SemanticProvider {
 public:
  SemanticProvider() = default;
  SemanticProvider(const SemanticProvider&) = delete;
  SemanticProvider& operator=(const SemanticProvider&) = delete;
  virtual ~SemanticProvider() = default;

  virtual std::string name() const = 0;  ///< its type, for messages

  /// Processes one image. The same image must give the same result.
  /// An empty optional means that there is no result for this image.
  /// May throw any std::exception. The caller reports it and continues without a result.
  virtual std::optional<SemanticResult> infer(const SemanticImage& image) = 0;
};

}  // namespace dynfilter
