// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "masks/object_tracker.hpp"

namespace dynfilter_test {

/// A textured rectangle before a textured wall, which does not move.
struct Block {
  std::string class_name;
  cv::Rect at_start;
  cv::Point2d px_per_image;  ///< from image `from` to image `to`
  int from = 0, to = 1 << 20;
  cv::Scalar colour;
  int hidden_from = 1 << 20, hidden_to = 1 << 20;  ///< behind a pillar: not visible in these images

  bool moves_at(int image) const { return px_per_image != cv::Point2d() && image > from && image <= to; }
  cv::Rect at(int image) const {
    const int steps = std::clamp(image, from, to) - from;
    return at_start + cv::Point(cvRound(px_per_image.x * steps), cvRound(px_per_image.y * steps));
  }
};

constexpr double kClipRate_hz = 10;
inline const cv::Size kClipSize(320, 200);

inline cv::Mat noise(cv::Size size, int seed, const cv::Scalar& colour) {
  cv::RNG random(static_cast<std::uint64_t>(seed));
  cv::Mat small(size / 4 + cv::Size(1, 1), CV_8UC3), large;
  random.fill(small, cv::RNG::UNIFORM, 0, 120);
  cv::resize(small, large, size, 0, 0, cv::INTER_CUBIC);
  return large + colour;
}

/// What a perfect detector and a perfect pipeline say of one image of the clip.
/// The last block is in front. Features are on a grid.
inline dynfilter::masks::TrackedImage clip_image(const std::vector<Block>& blocks, int image) {
  dynfilter::masks::TrackedImage out;
  out.frame = static_cast<std::size_t>(image);
  out.time_s = image / kClipRate_hz;
  out.colour = noise(kClipSize, 1, cv::Scalar(60, 60, 60));
  cv::Mat owner = cv::Mat::zeros(kClipSize, CV_8UC1);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const bool hidden = image >= blocks[b].hidden_from && image < blocks[b].hidden_to;
    const cv::Rect at = blocks[b].at(image), seen = at & cv::Rect({0, 0}, kClipSize);
    if (hidden || seen.empty()) continue;
    noise(at.size(), 10 + static_cast<int>(b), blocks[b].colour)(seen - at.tl()).copyTo(out.colour(seen));
    owner(seen).setTo(static_cast<double>(b + 1));
  }
  cv::cvtColor(out.colour, out.grey, cv::COLOR_BGR2GRAY);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const dynfilter::masks::RunMask mask(owner == static_cast<double>(b + 1));
    if (!mask.empty()) out.instances.push_back({mask, blocks[b].class_name});
  }
  for (int y = 4; y < kClipSize.height; y += 8) {
    for (int x = 4; x < kClipSize.width; x += 8) {
      const int b = owner.at<std::uint8_t>(y, x);
      const bool moves = b > 0 && blocks[static_cast<std::size_t>(b - 1)].moves_at(image);
      out.features.push_back({cv::KeyPoint(static_cast<float>(x), static_cast<float>(y), 31),
                              moves ? dynfilter::Vote::Dynamic : dynfilter::Vote::Static});
    }
  }
  return out;
}

inline std::vector<dynfilter::masks::ObjectTrack> tracks_of(const std::vector<Block>& blocks, int images) {
  dynfilter::masks::ObjectTracker tracker;
  for (int i = 0; i < images; ++i) tracker.add(clip_image(blocks, i));
  return tracker.finish();
}

}  // namespace dynfilter_test
