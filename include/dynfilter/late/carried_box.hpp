// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/late/motion_history.hpp>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
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

/// Writes the instance mask of a carried box, moved and scaled with it, to `out`.
/// CV_8UC1 at a quarter of the image's width and height.
void carried_instance(const CarriedBox& carried, cv::Size image_px, cv::Mat& out);

/// Carries boxes from frame to frame.
/// The median motion of the features on the object moves a box.
/// The ratio of the object's depths scales it.
/// The object is the depth layer with most features in the middle of the box.
/// Without depth, all features of the box count and its size is constant.
/// A box without features keeps its velocity, which decays.
class BoxCarrier {
 public:
  void carry(const MotionFrame& to, CarriedBox& box);

 private:
  static constexpr std::size_t kMinSamples = 3;
  static constexpr float kSlowDown = 0.9F;
  static constexpr float kLayer_m = 0.3F;  // half the depth extent of a person with arms

  void collect(const std::vector<MotionSample>& samples, const CarriedBox& box);

  /// The depth layer with most features in the middle of the box; the nearest layer wins a tie.
  float object_depth_m(const std::vector<MotionSample>& samples, const cv::Rect2f& box);

  std::vector<float> x_, y_, z_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/late/detail/carried_box-inl.hpp>
#endif
