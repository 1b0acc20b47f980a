// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/hosts/masked_image.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Which pixels of its mask a host drops. docs/how-to/mask_hosts.md has the hosts.
enum class MaskPolarity : std::uint8_t {
  NonzeroDrops,  ///< 255 on rejected features, 0 elsewhere: OpenVINS, cuVSLAM
  ZeroDrops,     ///< 0 on rejected features, 255 elsewhere: stella_vslam, pySLAM, Kimera-VIO
};

/// A verdict as the mask image or the depth image of a host that finds features itself.
/// Only discs around rejected features are dropped, and no pixel of a kept feature: the host keeps at least
/// the features that the floor kept. One object per camera stream. Buffers are kept.
class HostMask {
 public:
  /// Throws ConfigError for a parameter out of range.
  explicit HostMask(MaskPolarity polarity, const MaskedImageParams& params = MaskedImageParams())
      : polarity_(polarity), masked_(params) {}

  /// CV_8UC1 with 0 and 255, for a host of one camera or the left image of two. `keypoints`: the features of
  /// the verdict, in its order. Valid until the next call. Cost: a disc per feature, about 0.3 ms for 1000.
  const cv::Mat& image(Span<const cv::KeyPoint> keypoints, const Verdict& verdict, const cv::Size& size) {
    return polarised(masked_.mask(keypoints, verdict, size, false));
  }

  /// The same for a host with depth images, with the discs of depth().
  const cv::Mat& rgbd_image(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                            const cv::Size& size) {
    return polarised(masked_.mask(keypoints, verdict, size));
  }

  /// For the right image of rectified stereo: the discs of image(), shifted by the features' disparities.
  /// `right_u_px`: as FrameView has it. Features without a match have no disc there.
  const cv::Mat& right_image(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                             Span<const float> right_u_px, const cv::Size& size);

  /// A copy of the depth image (any type) with zero, that is no depth, on the same discs.
  /// Valid until the next call.
  const cv::Mat& depth(Span<const cv::KeyPoint> keypoints, const Verdict& verdict, const cv::Mat& depth) {
    MaskedImage::zero_depth(depth, masked_.mask(keypoints, verdict, depth.size()), depth_);
    return depth_;
  }

 private:
  const cv::Mat& polarised(const cv::Mat& mask) {
    if (polarity_ == MaskPolarity::NonzeroDrops) return mask;
    cv::bitwise_not(mask, inverted_);
    return inverted_;
  }

  MaskPolarity polarity_;
  MaskedImage masked_;
  std::vector<cv::KeyPoint> right_;
  cv::Mat inverted_, depth_;
};

/// Ids of the rejected features, in their order. `ids`: one per feature of the verdict.
template <class Id>
void rejected_ids(const Verdict& verdict, const std::vector<Id>& ids, std::vector<Id>& out) {
  out.clear();
  for (std::size_t i = 0; i < ids.size() && i < verdict.size(); ++i)
    if (!verdict.keep(i)) out.push_back(ids[i]);
}

/// 1: keep, 0: drop, one per feature: the status array that VINS-Fusion's reduceVector() takes.
/// T: `uchar` there.
template <class T>
void keep_status(const Verdict& verdict, std::vector<T>& out) {
  out.resize(verdict.size());
  for (std::size_t i = 0; i < verdict.size(); ++i) out[i] = static_cast<T>(verdict.keep(i) ? 1 : 0);
}

inline const cv::Mat& HostMask::right_image(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                                            Span<const float> right_u_px, const cv::Size& size) {
  right_.assign(keypoints.begin(), keypoints.end());
  for (std::size_t i = 0; i < right_.size(); ++i)
    right_[i].pt.x = i < right_u_px.size() && valid_right(right_u_px[i]) ? right_u_px[i] : NAN;  // no disc
  return image(right_, verdict, size);
}

}  // namespace dynfilter
