// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Where flow may start if features jump farther than it searches, as on a street at 10 Hz.
/// That is at the match of the feature's descriptor. About 0.4 ms for 1000 features.
class FlowStarts {
 public:
  /// Distorted pixels in the reference frame, one per feature. NaN: not known. Valid until the next call.
  Span<const cv::Point2f> find(const DescribedFeatures& current, const DescribedFeatures& reference) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    descriptors_.match(current, reference, {}, matches_);
    starts_px_ = matches_.reference_px;
    for (std::size_t i = 0; i < starts_px_.size(); ++i)
      if (matches_.found[i] == 0) starts_px_[i] = {kNone, kNone};
    return starts_px_;
  }

 private:
  static constexpr double kSearch_px = 120;  ///< a car at 8 m that comes nearer at 20 m/s, at 10 Hz

  static DescriptorMatchParams far() {
    DescriptorMatchParams params;
    params.search_radius_px = kSearch_px;
    return params;
  }

  DescriptorMatcher descriptors_{far()};
  Correspondences matches_;
  std::vector<cv::Point2f> starts_px_;
};

}  // namespace dynfilter
