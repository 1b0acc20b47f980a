// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/random.hpp>
#include <opencv2/core.hpp>
#include <vector>

/// Images that are the same on every machine: grey values by integer arithmetic, motions of whole pixels.
/// A wall at 3 m with a person at 1.5 m before it. The camera moves to the left, the person to the right.
namespace whole_pixel_scene {

inline constexpr int kWidth = 320, kHeight = 240;
inline constexpr int kWallStep_px = 3, kPersonStep_px = -5;  ///< to the right per frame
inline constexpr std::uint16_t kWall_mm = 3000, kPerson_mm = 1500;
inline constexpr int kWallDisparity_px = 10, kPersonDisparity_px = 20;  ///< of the stereo camera

/// Sums of hashed blocks of 3 and 7 pixels.
inline int texture(int x, int y, std::uint64_t seed) {
  const auto block = [&](int size_px) {
    const auto column = static_cast<std::uint64_t>((x + 4096) / size_px);
    const auto row = static_cast<std::uint64_t>((y + 4096) / size_px);
    return static_cast<int>(dynfilter::mix_bits(seed + 64 * column + (row << 20)) >> 57);
  };
  return block(3) + block(7);
}

class Frame {
 public:
  /// Without `stereo`, of an RGB-D camera.
  explicit Frame(int k, bool stereo = false)
      : grey_(kHeight, kWidth, CV_8UC1), right_(kHeight, kWidth, CV_8UC1), depth_(kHeight, kWidth, CV_16UC1) {
    const cv::Rect person(130 + kPersonStep_px * k, 60, 80, 170);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        grey_.at<std::uint8_t>(y, x) = grey(k, person, x, x, y);
        right_.at<std::uint8_t>(y, x) = grey(k, person, x + kPersonDisparity_px, x + kWallDisparity_px, y);
        depth_.at<std::uint16_t>(y, x) = person.contains({x, y}) ? kPerson_mm : kWall_mm;
      }
    for (int y = 16; y < kHeight - 16; y += 12)
      for (int x = 16; x < kWidth - 16; x += 12)
        keypoints_.emplace_back(static_cast<float>(x + y % 5), static_cast<float>(y + x % 3), 31.0F);
    dynfilter::Detection detection;
    detection.box = cv::Rect2f(person);
    detection.class_name = "person";
    detection.class_id = 0;
    detections_.push_back(detection);
    frame_.id = k;
    frame_.timestamp_s = k / 32.0;
    frame_.keypoints = keypoints_;
    frame_.grey = grey_;
    dynfilter::Camera camera;
    camera.fx_px = camera.fy_px = 256, camera.cx_px = kWidth / 2, camera.cy_px = kHeight / 2;
    camera.width_px = kWidth, camera.height_px = kHeight;
    if (stereo) {
      camera.baseline_fx_px_m = kWallDisparity_px * kWall_mm / 1000.0;
      frame_.right_grey = right_;
    } else {
      frame_.depth = depth_;
      frame_.depth_unit_m = 1.0 / 1024;
    }
    frame_.camera = camera;
    frame_.detections = dynfilter::DetectionInput{-1, detections_};
  }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;

  const dynfilter::FrameView& view() const { return frame_; }

 private:
  /// Where the person's place is `person_x`, and the wall's `wall_x`.
  static std::uint8_t grey(int k, const cv::Rect& person, int person_x, int wall_x, int y) {
    return static_cast<std::uint8_t>(person.contains({person_x, y})
                                         ? texture(person_x - kPersonStep_px * k, y, 11)
                                         : texture(wall_x - kWallStep_px * k, y, 22));
  }

  cv::Mat grey_, right_, depth_;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<dynfilter::Detection> detections_;
  dynfilter::FrameView frame_;
};

}  // namespace whole_pixel_scene
