// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "descriptor.hpp"
#include "options.hpp"
#include "spread.hpp"

namespace dynfilter::odometry {

/// ORB features (Rublee et al., ICCV 2011), spread over the image.
/// cv::ORB alone concentrates them on the strongest texture.
/// FAST corners per pyramid level and cell, suppression by square covering, orientation by intensity
/// centroid. The descriptor is OpenCV's.
/// Cost: about 8 ms for 1000 features of a 640x480 image.
class OrbExtractor {
 public:
  explicit OrbExtractor(const ExtractorOptions& options)
      : options_(options),
        orb_(cv::ORB::create(options.features, 1.2F, 1, kBorder)),
        levels_(options.levels) {
    for (int y = 0; y <= kHalfPatch; ++y)
      half_width_[y] = static_cast<int>(std::floor(std::sqrt(kHalfPatch * kHalfPatch - y * y)));
  }

  /// Replaces `keypoints` (pixels of `grey`, with octave, size and angle) and `descriptors`.
  void extract(const cv::Mat& grey, std::vector<cv::KeyPoint>& keypoints,
               std::vector<Descriptor>& descriptors) {
    keypoints.clear();
    descriptors.clear();
    const double shrink = 1.0 / options_.scale_factor;
    double share = (1 - shrink) / (1 - std::pow(shrink, options_.levels)), due = 0, scale = 1;
    for (int level = 0; level < options_.levels; ++level) {
      if (!build_level(grey, level, scale)) break;
      due += options_.features * share;  // later levels make up for missing features
      const int wanted = static_cast<int>(std::lround(due));
      due -= extract_level(level, scale, wanted, keypoints, descriptors);
      share *= shrink;
      scale *= options_.scale_factor;
    }
  }

  /// Pyramid level of the last image, CV_8UC1.
  const cv::Mat& level(int octave) const { return levels_[static_cast<std::size_t>(octave)]; }

 private:
  static constexpr int kHalfPatch = 15;
  static constexpr int kBorder = 19;  // keeps the descriptor's rotated patch inside

  bool build_level(const cv::Mat& grey, int level, double scale) {
    const cv::Size size(cvRound(grey.cols / scale), cvRound(grey.rows / scale));
    if (size.width <= 2 * kBorder + 2 || size.height <= 2 * kBorder + 2) return false;
    if (level == 0) {
      levels_[0] = grey;
    } else {
      cv::resize(levels_[level - 1], levels_[level], size, 0, 0, cv::INTER_LINEAR);
    }
    return true;
  }

  int extract_level(int level, double scale, int wanted, std::vector<cv::KeyPoint>& keypoints,
                    std::vector<Descriptor>& descriptors) {
    find_corners(levels_[level]);
    chosen_ = spreader_.spread(corners_, levels_[level].size(), wanted);
    if (chosen_.empty()) return 0;
    for (cv::KeyPoint& corner : chosen_) {
      corner.angle = orientation(levels_[level], corner.pt);
      corner.octave = 0;  // each level is a separate image for OpenCV, which then builds no pyramid
    }
    orb_->compute(levels_[level], chosen_, level_descriptors_);
    const std::size_t first = descriptors.size();
    descriptors.resize(first + chosen_.size());
    std::memcpy(descriptors[first].data(), level_descriptors_.data, chosen_.size() * sizeof(Descriptor));
    for (cv::KeyPoint& corner : chosen_) {
      corner.octave = level;
      corner.pt *= static_cast<float>(scale);
      corner.size = static_cast<float>(2 * kHalfPatch * scale);
      keypoints.push_back(corner);
    }
    return static_cast<int>(chosen_.size());
  }

  void find_corners(const cv::Mat& image) {
    constexpr int kRing = 3;  // margin of FAST itself
    const cv::Rect inner(kBorder, kBorder, image.cols - 2 * kBorder, image.rows - 2 * kBorder);
    corners_.clear();
    const int columns = std::max(1, inner.width / options_.cell_px),
              rows = std::max(1, inner.height / options_.cell_px);
    occupied_.assign(static_cast<std::size_t>(columns) * rows, 0);
    append_corners(image, inner, options_.fast_threshold, kRing);
    for (const cv::KeyPoint& corner : corners_) {
      const int column = (static_cast<int>(corner.pt.x) - inner.x) * columns / inner.width;
      const int row = (static_cast<int>(corner.pt.y) - inner.y) * rows / inner.height;
      occupied_[static_cast<std::size_t>(row) * columns + column] = 1;
    }
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        if (occupied_[static_cast<std::size_t>(row) * columns + column]) continue;
        const int x0 = inner.width * column / columns, x1 = inner.width * (column + 1) / columns;
        const int y0 = inner.height * row / rows, y1 = inner.height * (row + 1) / rows;
        append_corners(image, cv::Rect(inner.x + x0, inner.y + y0, x1 - x0, y1 - y0),
                       options_.fast_threshold_weak, kRing);
      }
    }
  }

  void append_corners(const cv::Mat& image, cv::Rect area, int threshold, int ring) {
    const cv::Rect padded(area.x - ring, area.y - ring, area.width + 2 * ring, area.height + 2 * ring);
    cv::FAST(image(padded), found_, threshold, true);
    for (cv::KeyPoint& corner : found_) {
      corner.pt += cv::Point2f(static_cast<float>(padded.x), static_cast<float>(padded.y));
      corners_.push_back(corner);
    }
  }

  float orientation(const cv::Mat& image, cv::Point2f at) const {
    const int x = cvRound(at.x), y = cvRound(at.y);
    int m10 = 0, m01 = 0;
    const std::uint8_t* centre = image.ptr<std::uint8_t>(y) + x;
    const auto step = static_cast<std::ptrdiff_t>(image.step);
    for (int u = -kHalfPatch; u <= kHalfPatch; ++u) m10 += u * centre[u];
    for (int v = 1; v <= kHalfPatch; ++v) {
      const std::uint8_t *below = centre + v * step, *above = centre - v * step;
      int difference = 0;
      for (int u = -half_width_[v]; u <= half_width_[v]; ++u) {
        difference += below[u] - above[u];
        m10 += u * (below[u] + above[u]);
      }
      m01 += v * difference;
    }
    return cv::fastAtan2(static_cast<float>(m01), static_cast<float>(m10));
  }

  ExtractorOptions options_;
  cv::Ptr<cv::ORB> orb_;
  std::vector<cv::Mat> levels_;
  std::array<int, kHalfPatch + 1> half_width_{};
  std::vector<cv::KeyPoint> found_, corners_, chosen_;
  std::vector<std::uint8_t> occupied_;
  cv::Mat level_descriptors_;
  Spreader spreader_;
};

}  // namespace dynfilter::odometry
