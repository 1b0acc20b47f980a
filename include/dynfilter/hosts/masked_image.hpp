// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter {

/// All 0 to kMax_px. A host that hardly finds features near movers needs a smaller radius_px.
struct MaskedImageParams {
  static constexpr double kMax_px = 500;
  double radius_px = 14;      ///< surroundings of a rejected feature of octave 0; 1.2 times more per octave
  double keep_radius_px = 7;  ///< surroundings that a kept feature protects
  double feather_px = 4;      ///< width of the soft edge of what is painted over
};

/// Hands a verdict to a host that nobody can patch: the images that it is given show nothing where features
/// were rejected. Without depth such a host makes no map points there; without texture it finds no features
/// there. Buffers are kept: nothing is allocated while the image size stays the same.
class MaskedImage {
 public:
  /// Throws ConfigError if a parameter is out of range.
  explicit MaskedImage(const MaskedImageParams& params = MaskedImageParams());

  /// CV_8UC1, 255 on what was rejected. `keypoints`: the features that the verdict is about, in the order of
  /// it. Valid until the next call. Cost: a disc per feature, about 0.3 ms for 1000.
  const cv::Mat& mask(Span<const cv::KeyPoint> keypoints, const Verdict& verdict, const cv::Size& size);

  /// A copy of the depth image (any type) with zero, that is no depth, where the mask is set. An image of
  /// another size than the mask is copied unchanged.
  static void zero_depth(const cv::Mat& depth, const cv::Mat& mask, cv::Mat& out);

  /// A copy of a grey or colour image that is smooth where the mask is set, with a soft edge. A hard one
  /// would be a new contour full of corners. About 2 ms for 640x480.
  void paint(const cv::Mat& image, const cv::Mat& mask, cv::Mat& out);

 private:
  void disc(const cv::KeyPoint& keypoint, double radius_px, int value);
  /// Blurred at an eighth of the size: smooth enough that no corner survives.
  void smooth(const cv::Mat& image);
  void feather(const cv::Mat& mask);

  MaskedImageParams params_;
  cv::Mat mask_, small_, smooth_, alpha_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/detail/masked_image-inl.hpp>
#endif
