// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

/// What hosts do with a mask or a depth image, as their sources say (docs/how-to/mask_hosts.md). Calls and
/// members have the same names. Written from scratch.
namespace stand_ins {

using Points = std::vector<cv::Point2f>;

/// stella_vslam: a feature on 0 is dropped.
struct StellaSystem {
  Points features;
  void feed_monocular_frame(const cv::Mat& image, double /*timestamp*/, const cv::Mat& mask) {
    CV_Assert(mask.type() == CV_8UC1 && mask.size() == image.size());
    Points left;
    for (const cv::Point2f& p : features)
      if (mask.at<std::uint8_t>(p) != 0) left.push_back(p);
    features = left;
  }
};

/// OpenVINS: a live track above 127 is dropped. There is a mask per image.
struct OpenVinsCameraData {
  std::vector<cv::Mat> images, masks;
};
struct OpenVinsTracker {
  Points tracks;
  void feed_new_camera(const OpenVinsCameraData& message) {
    CV_Assert(message.images.size() == message.masks.size());
    Points good;
    for (const cv::Point2f& p : tracks)
      if (message.masks[0].at<std::uint8_t>(p) <= 127) good.push_back(p);
    tracks = good;
  }
};

/// RTAB-Map: depth as mask. 16 bits are millimetres; 0 is no feature.
inline cv::Mat rtabmap_feature_mask(const cv::Mat& depth) {
  return depth > 0;
}

/// Kimera-VIO: features are detected where the mask is not 0. Tracked ones are drawn into the same mask.
struct KimeraFrame {
  cv::Mat img_;
  mutable cv::Mat detection_mask_;
  Points keypoints_;
};
inline Points kimera_detected(const KimeraFrame& frame, const Points& candidates, int min_distance_px) {
  const cv::Mat mask = frame.detection_mask_;  // shares the pixels
  for (const cv::Point2f& p : frame.keypoints_)
    cv::circle(mask, p, min_distance_px, cv::Scalar(0), cv::FILLED);
  Points found;
  for (const cv::Point2f& p : candidates)
    if (mask.at<std::uint8_t>(p) != 0) found.push_back(p);
  return found;
}

/// VINS-Fusion: arrays of one length, reduced by a status.
struct VinsFeatureTracker {
  Points prev_pts, cur_pts;
  std::vector<int> ids, track_cnt;
};
template <class T>
void reduceVector(std::vector<T>& v, const std::vector<uchar>& status) {
  CV_Assert(v.size() == status.size());
  std::size_t j = 0;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (status[i]) v[j++] = v[i];
  v.resize(j);
}

}  // namespace stand_ins
