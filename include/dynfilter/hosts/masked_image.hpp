// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace dynfilter {

/// Lengths are 0 to kMax_px. Large discs starve a host: without depth it finds no map to begin with.
struct MaskedImageParams {
  static constexpr double kMax_px = 500, kMostPerOctave = 4;
  double radius_px = 14;               ///< around a rejected feature of octave 0, for hosts with depth images
  double radius_without_depth_px = 7;  ///< the same for hosts of one camera or two
  double octave_scale = 1.2;           ///< a disc is so much larger per octave; 1: all are alike
  double keep_radius_px = 7;           ///< around a kept feature, which protects as much
  double feather_px = 4;               ///< width of the soft edge of what is painted over
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
  const cv::Mat& mask(Span<const cv::KeyPoint> keypoints, const Verdict& verdict, const cv::Size& size,
                      bool has_depth = true);

  /// A copy of the depth image (any type) with zero, that is no depth, where the mask is set. An image of
  /// another size than the mask is copied unchanged.
  static void zero_depth(const cv::Mat& depth, const cv::Mat& mask, cv::Mat& out) {
    depth.copyTo(out);
    if (out.size() == mask.size()) out.setTo(cv::Scalar::all(0), mask);
  }

  /// A copy of a grey or colour image that is smooth where the mask is set, with a soft edge. A hard one
  /// would be a new contour full of corners. About 2 ms for 640x480.
  void paint(const cv::Mat& image, const cv::Mat& mask, cv::Mat& out);

 private:
  void disc(const cv::KeyPoint& keypoint, double radius_px, int value);
  /// Blurred at an eighth of the size: smooth enough that no corner survives.
  void smooth(const cv::Mat& image);
  void feather(const cv::Mat& mask) {
    const int width = 2 * cvRound(params_.feather_px) + 1;
    cv::dilate(mask, alpha_, cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(width, width)));
    cv::blur(alpha_, alpha_, cv::Size(width, width));
  }

  MaskedImageParams params_;
  cv::Mat mask_, small_, smooth_, alpha_;
};

inline MaskedImage::MaskedImage(const MaskedImageParams& params) : params_(params) {
  using P = MaskedImageParams;
  for (const double px :
       {params.radius_px, params.radius_without_depth_px, params.keep_radius_px, params.feather_px})
    if (!(px >= 0 && px <= P::kMax_px))
      throw ConfigError("masked_image", "expected 0 to 500 px, got " + std::to_string(px));
  if (!(params.octave_scale >= 1 && params.octave_scale <= P::kMostPerOctave))
    throw ConfigError("masked_image",
                      "octave_scale: expected 1 to 4, got " + std::to_string(params.octave_scale));
}

inline const cv::Mat& MaskedImage::mask(Span<const cv::KeyPoint> keypoints, const Verdict& verdict,
                                        const cv::Size& size, bool has_depth) {
  const double radius_px = has_depth ? params_.radius_px : params_.radius_without_depth_px;
  mask_.create(size, CV_8UC1);
  mask_.setTo(0);
  const std::size_t n = std::min(keypoints.size(), verdict.size());
  for (std::size_t i = 0; i < n; ++i)
    if (!verdict.keep(i)) disc(keypoints[i], radius_px, 255);
  for (std::size_t i = 0; i < n; ++i)
    if (verdict.keep(i)) disc(keypoints[i], params_.keep_radius_px, 0);
  return mask_;
}

inline void MaskedImage::paint(const cv::Mat& image, const cv::Mat& mask, cv::Mat& out) {
  image.copyTo(out);
  if (image.empty() || image.depth() != CV_8U || image.size() != mask.size() || cv::countNonZero(mask) == 0)
    return;
  smooth(image);
  feather(mask);
  const int channels = image.channels();
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* a = alpha_.ptr(y);
    const std::uint8_t* s = smooth_.ptr(y);
    std::uint8_t* o = out.ptr(y);
    for (int x = 0; x < image.cols; ++x) {
      if (a[x] == 0) continue;
      for (int c = 0; c < channels; ++c) {
        const int k = x * channels + c;
        o[k] = static_cast<std::uint8_t>((o[k] * (255 - a[x]) + s[k] * a[x] + 127) / 255);
      }
    }
  }
}

inline void MaskedImage::disc(const cv::KeyPoint& keypoint, double radius_px, int value) {
  if (!std::isfinite(keypoint.pt.x) || !std::isfinite(keypoint.pt.y)) return;
  const double scale = std::pow(params_.octave_scale, std::clamp(keypoint.octave, 0, 16)),
               reach_px = std::min<double>(radius_px * scale, mask_.rows + mask_.cols);  // all of the image
  cv::circle(mask_, keypoint.pt, cvRound(reach_px), cv::Scalar(value), cv::FILLED);
}

inline void MaskedImage::smooth(const cv::Mat& image) {
  cv::resize(image, small_, cv::Size(std::max(1, image.cols / 8), std::max(1, image.rows / 8)), 0, 0,
             cv::INTER_AREA);
  cv::GaussianBlur(small_, small_, cv::Size(0, 0), 3);
  cv::resize(small_, smooth_, image.size(), 0, 0, cv::INTER_LINEAR);
}

}  // namespace dynfilter
