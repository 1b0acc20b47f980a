// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/hosts/draw_verdict.hpp>
#include <dynfilter/hosts/host_semantics.hpp>
#include <dynfilter/hosts/input_watch.hpp>
#include <dynfilter/hosts/masked_image.hpp>
#include <dynfilter/hosts/orb_slam/settings.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <opencv2/core/version.hpp>
#include <opencv2/features.hpp>  // goodFeaturesToTrack
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// For a host that cannot be patched, ORB-SLAM or other. Judges corners of its own and returns the images for
/// the host. With depth the image stays and the depth loses what is rejected; without, the image is painted
/// over there. One camera stream, one thread.
class MaskedHost {
 public:
  struct Images {
    cv::Mat image, depth;  ///< valid until the next call; `image` may be the caller's own
  };

  /// Reads camera, depth unit (`DepthMapFactor`), pipeline and `DynFilter.` keys from a settings file as
  /// ORB-SLAM2 and 3 have it. Throws ConfigError, and IoError for a camera that is no pinhole or not there.
  MaskedHost(const std::string& settings_file, int sensor, const Registry& registry = builtin_filters(),
             const MaskedImageParams& masking = MaskedImageParams(), const ProviderRegistry& providers = {})
      : MaskedHost(read_orb_slam_settings(settings_file, registry, providers), settings_file,
                   host_sensor(sensor), masking) {}
  MaskedHost(OrbSlamSettings settings, const std::string& camera_file, HostSensor sensor,
             const MaskedImageParams& masking = MaskedImageParams());

  /// Of the next image; they go before those of `DynFilter.boxes`, `masks` and `detector`.
  void set_detections(std::vector<Detection> detections) {
    semantics_.set_detections(std::move(detections), -1);
  }
  void set_mask(const cv::Mat& labels) { semantics_.set_mask(labels, -1); }

  /// `image`: 8 bits, grey or colour. `depth`: as the host takes it, CV_16U or CV_32F in units of `1 /
  /// DepthMapFactor` metres, or empty. Cost: the corners, about 5 ms for 640x480, and the pipeline.
  const Images& process(const cv::Mat& image, const cv::Mat& depth, double timestamp_s);

  void reset();

  const Verdict& verdict() const { return verdict_; }
  const std::vector<cv::KeyPoint>& judged_keypoints() const { return keypoints_; }
  std::string summary() const { return summary_line(verdict_.report); }
  cv::Mat draw(const cv::Mat& image) const { return draw_verdict(image, keypoints_, verdict_); }

  const Pipeline& pipeline() const { return pipeline_; }
  /// As OrbSlam::start_line().
  std::string start_line() const;
  /// When an input never came in the first frames, or the detector failed: the last such line; "" without.
  const std::string& warning() const { return warning_; }

 private:
  static constexpr int kMaxCorners = 1000;

  void watch();

  void to_grey(const cv::Mat& image);
  /// Evenly spread, as the host's features are.
  void find_corners();

  void judge(const cv::Mat& image, const cv::Mat& depth, double timestamp_s);

  OrbSlamParams params_;
  HostSensor sensor_;
  std::string pipeline_file_, warning_;
  HostSemantics semantics_;
  Pipeline pipeline_;
  InputWatch watch_;
  MaskedImage masked_;
  Camera camera_;
  double depth_unit_m_ = 1;
  std::int64_t next_id_ = 0;
  bool first_frame_ = true;
  cv::Mat grey_, masked_depth_, painted_;
  std::vector<cv::Point2f> corners_;
  std::vector<cv::KeyPoint> keypoints_;
  Verdict verdict_;
  Images images_;
};

inline MaskedHost::MaskedHost(OrbSlamSettings settings, const std::string& camera_file, HostSensor sensor,
                              const MaskedImageParams& masking)
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
}

inline const MaskedHost::Images& MaskedHost::process(const cv::Mat& image, const cv::Mat& depth,
                                                     double timestamp_s) {
  images_.image = image, images_.depth = depth;
  if (!params_.enabled || image.empty() || image.depth() != CV_8U) return images_;
  to_grey(image);
  find_corners();
  judge(image, depth, timestamp_s);
  if (verdict_.kept() == verdict_.size()) return images_;
  const cv::Mat& mask = masked_.mask(keypoints_, verdict_, image.size());
  if (!depth.empty()) {
    MaskedImage::zero_depth(depth, mask, masked_depth_);
    images_.depth = masked_depth_;
  } else {
    masked_.paint(image, mask, painted_);
    images_.image = painted_;
  }
  return images_;
}

inline void MaskedHost::reset() {
  pipeline_.reset();
  semantics_.reset();
  first_frame_ = true;
}

inline std::string MaskedHost::start_line() const {
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
