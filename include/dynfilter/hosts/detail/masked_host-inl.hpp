// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/masked_host.hpp>

#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/needs.hpp>
#include <opencv2/core/version.hpp>
#include <opencv2/imgproc.hpp>

#if CV_VERSION_MAJOR >= 5 && __has_include(<opencv2/features.hpp>)
#include <opencv2/features.hpp>  // goodFeaturesToTrack
#endif

#include <limits>

namespace dynfilter {

DYNFILTER_INLINE MaskedHost::MaskedHost(OrbSlamSettings settings, const std::string& camera_file,
                                        HostSensor sensor, const MaskedImageParams& masking)
    : params_(settings.params),
      sensor_(sensor),
      pipeline_file_(std::move(settings.pipeline_file)),
      semantics_(std::move(settings.semantics)),
      pipeline_(configured_pipeline(settings)),
      watch_(pipeline_),
      masked_(masking) {
  const io::CameraFile file = io::read_camera(camera_file);
  camera_ = file.camera;
  if (file.depth_units_per_m && *file.depth_units_per_m > 0) depth_unit_m_ = 1 / *file.depth_units_per_m;
  start_recording(params_, pipeline_);
}

DYNFILTER_INLINE const MaskedHost::Images& MaskedHost::process(const cv::Mat& image, const cv::Mat& depth,
                                                               double timestamp_s) {
  images_.image = image, images_.depth = depth;
  if (!params_.enabled || image.empty() || image.depth() != CV_8U) return images_;
  to_grey(image);
  find_corners();
  judge(image, depth, timestamp_s);
  if (verdict_.kept() == verdict_.size()) return images_;
  const cv::Mat& mask = masked_.mask(keypoints_, verdict_, image.size(), !depth.empty());
  if (!depth.empty()) {
    MaskedImage::zero_depth(depth, mask, masked_depth_);
    images_.depth = masked_depth_;
  } else {
    masked_.paint(image, mask, painted_);
    images_.image = painted_;
  }
  return images_;
}

DYNFILTER_INLINE void MaskedHost::reset() {
  pipeline_.reset();
  semantics_.reset();
  first_frame_ = true;
}

DYNFILTER_INLINE std::string MaskedHost::start_line() const {
  Input given = Input::GreyImage | Input::Camera | Input::Correspondence | semantic_inputs(params_);
  if (sensor_ == HostSensor::RgbD) given = given | Input::Depth;
  return watch_.start_line(pipeline_file_, given);
}

inline void MaskedHost::watch() {
  watch_.saw(verdict_.report, pipeline_.inputs(), verdict_.report.rejected + verdict_.report.restored);
  const std::string missing = watch_.take_warning(), error = semantics_.take_error();
  if (!missing.empty()) warning_ = "dynfilter: warning: " + missing;
  if (!error.empty()) warning_ = "dynfilter: warning: the detector failed: " + error;
}

inline void MaskedHost::to_grey(const cv::Mat& image) {
  if (image.channels() == 1)
    image.copyTo(grey_);
  else
    cv::cvtColor(image, grey_, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
}

inline void MaskedHost::find_corners() {
  cv::goodFeaturesToTrack(grey_, corners_, kMaxCorners, 0.003, 8);
  keypoints_.clear();
  for (const cv::Point2f& corner : corners_) keypoints_.emplace_back(corner, 31.0F);
}

inline void MaskedHost::judge(const cv::Mat& image, const cv::Mat& depth, double timestamp_s) {
  FrameView view;
  view.id = next_id_++;
  view.timestamp_s = timestamp_s;
  view.keypoints = keypoints_;
  view.grey = grey_;
  view.depth = depth;
  view.depth_unit_m = depth_unit_m_;
  if (camera_.valid()) view.camera = camera_;
  semantics_.begin({view.id, timestamp_s, image.channels() == 4 ? grey_ : image, depth, depth_unit_m_});
  semantics_.add_to(view);
  const bool keep_all = first_frame_ && params_.keep_first_frame;
  verdict_ = pipeline_.before_pose(view, {keep_all ? std::numeric_limits<int>::max() : 0});
  watch();
  first_frame_ = false;
}

}  // namespace dynfilter
