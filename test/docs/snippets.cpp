// SPDX-License-Identifier: MIT
// The C++ of the pages, with the variables that a reader has.
#include <cstdint>
#include <dynfilter/dense/dense_mask.hpp>
#include <dynfilter/detectors/dnn_provider.hpp>
#include <dynfilter/dynfilter.hpp>
#include <dynfilter/hosts/host_mask.hpp>
#include <dynfilter/hosts/orb_slam.hpp>
#include <dynfilter/inertial/gyroscope.hpp>
#include <dynfilter/keyframe/make_selector.hpp>
#include <dynfilter/mapping/mapping_thread.hpp>
#include <dynfilter/mapping/static_map.hpp>
#include <dynfilter/plugin/export.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <dynfilter/semantic/async_runner.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <iostream>
#include <memory>
#include <opencv2/features2d.hpp>
#include <optional>
#include <unordered_map>
#include <vector>

#include "dark_blobs.hpp"
#include "io/ply.hpp"
#include "io/sequence.hpp"
#include "odometry/odometry.hpp"
#include "render/sequence_writer.hpp"

namespace {

using namespace dynfilter;

// What the readers' programs have.
std::int64_t n, k, id, frame_id;
double t, stamp, timestamp, timestamp_s, cur_time;
cv::Mat grey, depth, bgr, left, right, mask, cur_img, image;
std::vector<cv::KeyPoint> keypoints;
std::vector<Detection> boxes, detections;
std::vector<cv::Point2f> prev_pts, cur_pts;
std::vector<int> ids, track_cnt;
std::vector<float> right_u_px;
std::unordered_map<int, std::int32_t> place_of_id;
const Camera camera;
const FrameView frame;
Pose T_world_camera;

void track(const cv::KeyPoint&) {}

template <class T>
void reduceVector(std::vector<T>&, const std::vector<uchar>&) {}

struct Host {
  void feed_monocular_frame(const cv::Mat&, double, const cv::Mat&) {}
  void feed_RGBD_frame(const cv::Mat&, const cv::Mat&, double, const cv::Mat&) {}
  void feed_stereo_frame(const cv::Mat&, const cv::Mat&, double, const cv::Mat&) {}
};

}  // namespace

void readme() {
#include "README_1.inc"
}

void any_front_end(FrameView& view, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
#include "any_front_end_1.inc"
}

void report_of(const Verdict& verdict) {
#include "any_front_end_2.inc"
}

void vins_mono(Pipeline& pipeline) {
#include "any_front_end_3.inc"
}

void dense_map(const mapping::MapFrame& other_frame) {
#include "dense_map_1.inc"
}

void detectors() {
#include "detectors_1.inc"
}

void late_results(Pipeline& pipeline, FrameView& view, std::unique_ptr<SemanticProvider> provider) {
#include "late_results_1.inc"
}

void host_mask(Pipeline& pipeline) {
#include "mask_hosts_1.inc"
#include "mask_hosts_2.inc"
}

void stella_masks(Host& slam, HostMask& host, const Verdict& verdict) {
#include "mask_hosts_3.inc"
}

namespace ov_core {
struct CameraData {
  std::vector<cv::Mat> images, masks;
};
}  // namespace ov_core

struct VioManager {
  void feed_measurement_camera(const ov_core::CameraData&) {}
};

void openvins(VioManager* sys, HostMask& host, const Verdict& verdict) {
#include "mask_hosts_4.inc"
}

void vins_status(Pipeline& pipeline) {
#include "mask_hosts_5.inc"
}

struct KimeraFrame {
  cv::Mat detection_mask_;
};

struct FeatureDetector {
  void featureDetection(KimeraFrame*) {}
};

void kimera(KimeraFrame* left_frame, FeatureDetector* feature_detector_, HostMask& host,
            const Verdict& verdict) {
#include "mask_hosts_6.inc"
}

void plugins() {
#include "plugins_1.inc"
}

void keyframes(const FrameSummary& summary) {
  const auto map = [](std::int64_t) {};
#include "keyframes_1.inc"
}

void synth() {
#include "synth_1.inc"
}

void component(const io::SequenceFrame& frame, odometry::FeatureJudge& judge) {
  using namespace odometry;
  const DetectionInput detections;
  const MaskInput mask;
#include "odometry_1.inc"
}

#include "detectors_2.inc"

// Stand-ins with the members of visual-inertial hosts, as their sources name them.
namespace inertial_hosts {

const Eigen::Matrix3d R_camera_body = Eigen::Matrix3d::Identity(), R_current_reference = R_camera_body;
FrameView view;
double last_stamp_s, stamp_s;
const Eigen::Vector3d omega_radps(0, 0, 0);
Pose T_world_camera_last;

void in_a_program() {
#include "gyroscope_1.inc"
}
void wheels(){
#include "gyroscope_2.inc"
}

Gyroscope gyroscope({R_camera_body, {}});

struct ImuPoint {
  Eigen::Vector3f a, w;
  double t;
};
struct OrbFrame {
  double mTimeStamp;
};
void orb_slam3(const ImuPoint& imuMeasurement, OrbSlam* dyn_filter) {
  const OrbFrame mLastFrame{0}, mCurrentFrame{1};
#include "gyroscope_3.inc"
}

struct ImuData {
  double timestamp;
  Eigen::Matrix<double, 3, 1> wm, am;
};
void open_vins(const ImuData& message) {
#include "gyroscope_4.inc"
}

void vins_fusion(double t, const Eigen::Vector3d& angularVelocity) {
#include "gyroscope_5.inc"
}

struct Rot3 {
  Eigen::Matrix3d matrix() const { return Eigen::Matrix3d::Identity(); }
};
void kimera_vio(const Rot3& ref_frame_R_cur_frame) {
#include "gyroscope_6.inc"
}

}  // namespace inertial_hosts
