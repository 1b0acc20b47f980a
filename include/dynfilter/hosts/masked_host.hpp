// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/hosts/draw_verdict.hpp>
#include <dynfilter/hosts/host_semantics.hpp>
#include <dynfilter/hosts/input_watch.hpp>
#include <dynfilter/hosts/masked_image.hpp>
#include <dynfilter/hosts/orb_slam/settings.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// For a host that cannot be patched, ORB-SLAM or other. Judges corners of its own and returns the images for
/// the host. With depth the image stays and the depth loses what is rejected; without, the image is painted
/// over there. One camera stream, one thread.
class MaskedHost {
 public:
  /// What the host processes instead of its own images.
  struct Images {
    cv::Mat image, depth;  ///< valid until the next call; `image` may be the caller's own
  };

  /// Reads camera, depth unit (`DepthMapFactor`), pipeline and keys `DynFilter.NAME` from a settings file as
  /// ORB-SLAM2 and 3 have it. Throws ConfigError, and IoError for a camera that is no pinhole or not there.
  MaskedHost(const std::string& settings_file, int sensor, const Registry& registry = builtin_filters(),
             const MaskedImageParams& masking = MaskedImageParams(), const ProviderRegistry& providers = {})
      : MaskedHost(read_orb_slam_settings(settings_file, registry, providers), settings_file,
                   host_sensor(sensor), masking) {}
  /// The same with settings that were read before; throws as above.
  MaskedHost(OrbSlamSettings settings, const std::string& camera_file, HostSensor sensor,
             const MaskedImageParams& masking = MaskedImageParams());

  /// Of the next image; they go before those of `DynFilter.boxes`, `masks` and `detector`.
  void set_detections(std::vector<Detection> detections) {
    semantics_.set_detections(std::move(detections), -1);
  }
  /// CV_8UC1, 0: background; of the next image.
  void set_mask(const cv::Mat& labels) { semantics_.set_mask(labels, -1); }

  /// `image`: 8 bits, grey or colour. `depth`: as the host takes it, CV_16U or CV_32F in units of `1 /
  /// DepthMapFactor` metres, or empty. Cost: the corners, about 5 ms for 640x480, and the pipeline.
  const Images& process(const cv::Mat& image, const cv::Mat& depth, double timestamp_s);

  void reset();

  /// Of the last image, in the order of judged_keypoints().
  const Verdict& verdict() const { return verdict_; }
  /// Corners of the last image [px].
  const std::vector<cv::KeyPoint>& judged_keypoints() const { return keypoints_; }
  std::string summary() const { return summary_line(verdict_.report); }  ///< one line on the last image
  /// On a picture of the last image; red: rejected.
  cv::Mat draw(const cv::Mat& image) const { return draw_verdict(image, keypoints_, verdict_); }

  const Pipeline& pipeline() const { return pipeline_; }  ///< its name, stages and needs
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/detail/masked_host-inl.hpp>
#endif
