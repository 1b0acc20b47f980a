// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/host_mask.hpp>

#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE const cv::Mat& HostMask::image(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                                                const cv::Size& size) {
  const cv::Mat& mask = masked_.mask(keypoints, verdict, size);
  if (polarity_ == MaskPolarity::NonzeroDrops) return mask;
  cv::bitwise_not(mask, inverted_);
  return inverted_;
}

DYNFILTER_INLINE const cv::Mat& HostMask::depth(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                                                const cv::Mat& depth) {
  MaskedImage::zero_depth(depth, masked_.mask(keypoints, verdict, depth.size()), depth_);
  return depth_;
}

}  // namespace dynfilter
