// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/late/motion_history.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// A box carried forward from the frame of its detection.
/// `detection.box` is its position in the current frame.
struct CarriedBox {
  Detection detection;
  cv::Rect2f found_box;  ///< position at detection
  float found_depth_m = std::numeric_limits<float>::quiet_NaN();
  float depth_m = std::numeric_limits<float>::quiet_NaN();  ///< depth of the object
  cv::Point2f velocity_px;                                  ///< pixels per frame
  std::int64_t found_id = -1;                               ///< frame of the detection
  int hits = 1;                                             ///< number of results that contain it

  /// Shares the pixels of the mask.
  static CarriedBox from(const Detection& detection, std::int64_t frame_id);
};

/// Carries boxes from frame to frame. The median motion of the features on the object moves a box. The ratio
/// of the object's depths scales it. The object is the depth layer with most features in the middle of the
/// box. Without depth, all features of the box count and its size is constant. A box without features keeps
/// its velocity, which decays.
class BoxCarrier {
 public:
  void carry(const MotionFrame& to, CarriedBox& box);  ///< moves the box to this frame [px], or loses it

 private:
  static constexpr std::size_t kMinSamples = 3;
  static constexpr float kSlowDown = 0.9F;
  static constexpr float kLayer_m = 0.3F;  // half the depth extent of a person with arms

  void collect(const std::vector<MotionSample>& samples, const CarriedBox& box);

  /// The depth layer with most features in the middle of the box; the nearest layer wins a tie.
  float object_depth_m(const std::vector<MotionSample>& samples, const cv::Rect2f& box);

  std::vector<float> x_, y_, z_;
};

inline CarriedBox CarriedBox::from(const Detection& detection, std::int64_t frame_id) {
  CarriedBox box;
  box.detection = detection;
  box.found_box = detection.box;
  box.found_id = frame_id;
  return box;
}

/// Writes the instance mask of a carried box, moved and scaled with it, to `out`.
/// CV_8UC1 at a quarter of the image's width and height.
inline void carried_instance(const CarriedBox& carried, cv::Size image_px, cv::Mat& out) {
  const cv::Mat& mask = carried.detection.mask;
  const cv::Rect2f &now = carried.detection.box, &then = carried.found_box;
  const auto cell = static_cast<float>(MotionHistory::kCellPx);
  out.create((image_px.height + MotionHistory::kCellPx - 1) / MotionHistory::kCellPx,
             (image_px.width + MotionHistory::kCellPx - 1) / MotionHistory::kCellPx, CV_8UC1);
  out.setTo(cv::Scalar(0));
  if (mask.type() != CV_8UC1 || mask.empty() || !(now.width > 0) || !(now.height > 0)) return;
  const float to_mask_x = static_cast<float>(mask.cols) / static_cast<float>(image_px.width),
              to_mask_y = static_cast<float>(mask.rows) / static_cast<float>(image_px.height);
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c) {
      const cv::Point2f px((static_cast<float>(c) + 0.5F) * cell, (static_cast<float>(r) + 0.5F) * cell);
      const float x = ((px.x - now.x) / now.width * then.width + then.x) * to_mask_x,
                  y = ((px.y - now.y) / now.height * then.height + then.y) * to_mask_y;
      // Compared before they are converted: a narrow box gives values that do not fit an int.
      if (x >= 0 && y >= 0 && x < static_cast<float>(mask.cols) && y < static_cast<float>(mask.rows))
        out.at<std::uint8_t>(r, c) = mask.at<std::uint8_t>(static_cast<int>(y), static_cast<int>(x));
    }
}

inline void BoxCarrier::carry(const MotionFrame& to, CarriedBox& box) {
  if (!std::isfinite(box.depth_m))
    box.found_depth_m = box.depth_m = object_depth_m(to.samples, box.detection.box);
  collect(to.samples, box);
  if (x_.size() >= kMinSamples) {
    box.velocity_px = {median_in_place(x_), median_in_place(y_)};
    if (!z_.empty()) box.depth_m = median_in_place(z_);
  } else {
    box.velocity_px *= kSlowDown;
  }
  const cv::Rect2f& was = box.detection.box;
  const cv::Point2f centre(was.x + was.width / 2 + box.velocity_px.x,
                           was.y + was.height / 2 + box.velocity_px.y);
  float scale = box.found_depth_m / box.depth_m;
  scale = std::isfinite(scale) ? std::clamp(scale, 0.5F, 2.0F) : 1.0F;
  const cv::Size2f size = box.found_box.size() * scale;
  box.detection.box = {centre.x - size.width / 2, centre.y - size.height / 2, size.width, size.height};
}

inline void BoxCarrier::collect(const std::vector<MotionSample>& samples, const CarriedBox& box) {
  x_.clear(), y_.clear(), z_.clear();
  for (const MotionSample& s : samples) {
    if (!box.detection.box.contains(s.from_px)) continue;
    if (std::isfinite(box.depth_m) && !(std::abs(s.from_depth_m - box.depth_m) <= kLayer_m)) continue;
    x_.push_back(s.to_px.x - s.from_px.x);
    y_.push_back(s.to_px.y - s.from_px.y);
    if (std::isfinite(s.to_depth_m) && std::abs(s.to_depth_m - s.from_depth_m) <= kLayer_m)
      z_.push_back(s.to_depth_m);
  }
}

inline float BoxCarrier::object_depth_m(const std::vector<MotionSample>& samples, const cv::Rect2f& box) {
  const cv::Rect2f middle(box.x + 0.2F * box.width, box.y + 0.1F * box.height, 0.6F * box.width,
                          0.8F * box.height);
  z_.clear();
  for (const MotionSample& s : samples)
    if (middle.contains(s.from_px) && std::isfinite(s.from_depth_m)) z_.push_back(s.from_depth_m);
  if (z_.size() < kMinSamples) return std::numeric_limits<float>::quiet_NaN();
  return *densest_in_place(z_, kLayer_m);
}

}  // namespace dynfilter
