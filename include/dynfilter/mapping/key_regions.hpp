// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::mapping {

/// The pixels of static key objects (RTS-SLAM, Algorithm 2, lines 5 to 10).
/// These are the boxes or instance masks of the listed classes, without moving pixels.
/// Classes are numbered from 1 in list order.
class KeyRegions {
 public:
  explicit KeyRegions(std::vector<std::string> classes = {}) : classes_(std::move(classes)) {}

  bool any(Span<const Detection> detections) const;
  /// Number of a detection's class; 0: not a key class.
  int label_of(const Detection& detection) const;

  /// `usable`: CV_8UC1, not 0: belongs in the map. Where boxes overlap, the higher score wins.
  void mark(Span<const Detection> detections, const cv::Mat& usable);

  const cv::Mat& inside() const { return inside_; }  ///< CV_8UC1: class numbers, 0 outside
  /// CV_8UC1: usable and outside all key regions.
  const cv::Mat& outside() const { return outside_; }
  cv::Rect area() const { return area_; }  ///< bounds of all key regions

 private:
  void mark_one(const Detection& d);

  std::vector<std::string> classes_;
  cv::Mat inside_, outside_own_, outside_;
  cv::Rect area_;
};

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/key_regions-inl.hpp>
#endif
