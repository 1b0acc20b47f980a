// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/hosts/host_mask.hpp>
#include <dynfilter/hosts/masked_image.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// The depth image of a frame; empty: none.
struct DepthImage {
  cv::Mat image;  ///< CV_16UC1 or CV_32FC1, of the mask's size
  double unit_m = 1;
};

/// A verdict as the mask of a host that uses every pixel: discs around rejected features, and triangles
/// between neighbours that are all rejected. With depth it is cut to what is as far away as the nearest
/// rejected feature. Features that the floor restored count as rejected, and groups of fewer than four as
/// wrong matches. One object per camera stream. Buffers are kept.
class DenseMask {
 public:
  /// `polarity`: which pixels of image() the host drops.
  explicit DenseMask(MaskPolarity polarity = MaskPolarity::NonzeroDrops);

  /// CV_8UC1 with 0 and 255. `keypoints`: the features of the verdict, in its order. A depth image of another
  /// size is not used. Valid until the next call. Cost: 640x480, 1000 features: about 10 ms with depth.
  const cv::Mat& image(Span<const cv::KeyPoint> keypoints, const Verdict& verdict, const cv::Size& size,
                       const DepthImage& depth = {});

  /// A copy of the depth image with zero, that is no depth, where the mask drops. Valid until the next call.
  const cv::Mat& depth(Span<const cv::KeyPoint> keypoints, const Verdict& verdict, const DepthImage& depth);

 private:
  const cv::Mat& draw(Span<const cv::KeyPoint> keypoints, const Verdict& verdict, const cv::Size& size,
                      const DepthImage& depth);
  void split(Span<const cv::KeyPoint> keypoints, const Verdict& verdict);
  void find_groups();
  bool rejected(std::size_t i) const;
  const cv::Mat& seeds_of(Vote decision);
  void leave_to_kept();
  std::vector<float> depths_of_movers(const DepthImage& depth) const;
  void keep_surface(const DepthImage& depth);

  MaskPolarity polarity_;
  cv::Size size_;
  double scale_ = 1;  ///< of lengths, against an image of 640x480
  MaskedImage discs_;
  std::vector<cv::KeyPoint> keypoints_;  ///< judged ones
  Verdict verdict_;
  std::vector<std::array<std::size_t, 2>> links_;    ///< rejected neighbours
  std::vector<std::array<cv::Point, 3>> triangles_;  ///< between members of one group
  cv::Mat mask_, seeds_, distance_px_, nearest_, inverted_, holes_;
};

}  // namespace dynfilter
