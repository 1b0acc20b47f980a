// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/adapters/draw_verdict.hpp>
#include <dynfilter/adapters/orb_slam/compact_frame.hpp>
#include <dynfilter/adapters/orb_slam/host_pose.hpp>
#include <dynfilter/adapters/orb_slam/read_frame.hpp>
#include <dynfilter/adapters/orb_slam/settings.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Judges and thins the frames of an ORB-SLAM2 or ORB-SLAM3 fork (docs/orb-slam.md). A member of the host's
/// Tracking, called from its thread only; templates on the host's own types, told apart at compile time.
///
/// Odd data never throws: images of a new size, no depth, an empty pose, no features, time that jumps back
/// and a frame number that starts again are all taken (the last two forget the history). Wrong settings throw
/// ConfigError when it is made. Reading and thinning cost less than 0.1 ms for 1000 features, beside the
/// pipeline's own time.
class OrbSlam {
 public:
  /// `sensor`: the host's System::eSensor as a number, or HostSensor.
  OrbSlam(const std::string& settings_file, int sensor, const Registry& registry = builtin_filters())
      : OrbSlam(read_orb_slam_settings(settings_file, host_sensor(sensor), registry), host_sensor(sensor)) {}
  OrbSlam(OrbSlamSettings settings, HostSensor sensor)
      : params_(settings.params),
        pipeline_(std::move(settings.pipeline)),
        running_floor_(floor_of(params_.min_features)),
        floor_before_map_(floor_of(params_.floor_before_map(sensor))),
        first_frame_floor_(floor_of(std::numeric_limits<int>::max())) {
    check_parameters(params_, "DynFilter");
  }

  // ---- what a detector or a segmenter found; used by the next frame that is judged, then forgotten
  /// `frame_id`: the host's mnId of the frame they were computed on, -1: the next one. An empty list means
  /// that nothing was found; masks inside are not copied.
  void set_detections(std::vector<Detection> detections, std::int64_t frame_id = -1) {
    detections_ = std::move(detections);
    detections_frame_id_ = frame_id;
  }
  /// CV_8UC1, 0 = background. Not copied: it must live until the frame is judged.
  void set_mask(const cv::Mat& labels, std::int64_t frame_id = -1) { mask_ = MaskInput{frame_id, labels}; }

  // ---- the call points
  /// A: in the Frame's constructor, after the extraction and before `N` is set. Thins mvKeys and
  /// mDescriptors.
  template <class Frame>
  const Verdict& after_extraction(Frame& frame, const cv::Mat& grey, cv::Mat depth, bool map_exists) {
    if (!judge_first(frame, grey, std::move(depth), map_exists, {})) return verdict_;
    orb_slam::compact_extracted(frame.mvKeys, frame.mDescriptors, verdict_);
    return verdict_;
  }

  /// B: in GrabImage..., after the Frame is made and before Track(). `grey`: CV_8UC1. `depth`: CV_32FC1 in
  /// metres or CV_16UC1 with `depth_unit_m`; empty for one camera or two; with
  /// std::move() it is handed over and, if nobody else has its memory, kept without a copy. `map_exists`: the
  /// host is past its initialisation (`mState >= OK`). `pose`: orb_slam::predicted_pose(mVelocity,
  /// mLastFrame), or nothing.
  template <class Frame>
  const Verdict& before_tracking(Frame& frame, const cv::Mat& grey, cv::Mat depth, bool map_exists,
                                 const orb_slam::HostPose& pose = {}) {
    if (judge_first(frame, grey, std::move(depth), map_exists, pose))
      orb_slam::compact_frame(frame, verdict_);
    return verdict_;
  }

  /// C: before TrackLocalMap(): the frame has a first pose and matched map points. Uses the images that were
  /// given at A or B for the same frame.
  template <class Frame>
  const Verdict& after_pose(Frame& frame) {
    if (!params_.enabled) return nothing_judged();
    judge(view_of_known(frame), CallPoint::AfterPose);
    running_floor_.apply(view_, verdict_);
    finish();
    orb_slam::compact_frame(frame, verdict_);
    return verdict_;
  }

  /// In CreateNewKeyFrame, before the KeyFrame is made of the frame: judges features and map points against
  /// the covisible keyframes (mvpLocalKeyFrames), thins the frame, and returns the map points that moved, for
  /// the host to erase (SetBadFlag).
  template <class Frame, class KeyFrame>
  std::vector<orb_slam::MapPointOf<Frame>*> at_keyframe(Frame& frame,
                                                        const std::vector<KeyFrame*>& keyframes) {
    std::vector<orb_slam::MapPointOf<Frame>*> moved;
    if (!params_.enabled) return moved;
    FrameView view = view_of_known(frame);
    if (!orb_slam::is_fisheye(frame))
      view.covisible_keyframes = keyframe_reader_.read(keyframes, params_.covisible_keyframes);
    judge(view, CallPoint::AtKeyframe);
    running_floor_.apply(view_, verdict_);
    finish();
    for (std::size_t i = 0; i < verdict_.size() && i < frame.mvpMapPoints.size(); ++i)
      if (!verdict_.keep(i) && frame.mvpMapPoints[i] != nullptr) moved.push_back(frame.mvpMapPoints[i]);
    orb_slam::compact_frame(frame, verdict_);
    return moved;
  }

  /// In Tracking::Reset: forgets everything; the next frame is a first frame.
  void reset() {
    pipeline_.reset();
    grey_.release(), depth_.release();
    last_id_.reset();
    first_frame_ = true;
  }

  // ---- what happened
  /// Of the last call; in the order of judged_keypoints(), which is the host's order before it was thinned.
  const Verdict& verdict() const { return verdict_; }
  const std::vector<cv::KeyPoint>& judged_keypoints() const { return keypoints_; }
  std::string summary() const { return summary_line(verdict_.report); }
  /// See draw_verdict(): red is rejected.
  cv::Mat draw(const cv::Mat& image) const { return draw_verdict(image, keypoints_, verdict_); }
  const OrbSlamParams& params() const { return params_; }
  /// Metres per unit of a CV_16UC1 depth image.
  void set_depth_unit_m(double depth_unit_m) { depth_unit_m_ = depth_unit_m; }

 private:
  static FloorParams floor_of(int min_features) {
    FloorParams params;
    params.min_features = min_features;
    return params;
  }

  template <class Frame>
  bool judge_first(const Frame& frame, const cv::Mat& grey, cv::Mat&& depth, bool map_exists,
                   const orb_slam::HostPose& pose) {
    if (!params_.enabled) {
      nothing_judged();
      return false;
    }
    note_restart(static_cast<std::int64_t>(frame.mnId));
    grey_ = grey, depth_ = std::move(depth);
    const bool handed_over = has_sole_owner(depth_);
    FrameView view = reader_.read(frame, grey_, depth_, depth_unit_m_);
    view.depth_handed_over = handed_over;
    if (pose.has_last)
      pipeline_.update_pose(pose.last_frame_id, pose.last_T_world_camera, PoseProvenance::Estimated);
    if (pose.has_prediction)
      view.T_world_camera = pose.predicted_T_world_camera, view.pose_provenance = PoseProvenance::Predicted;
    add_semantics(view);
    judge(view, CallPoint::BeforePose);
    Floor& floor = map_exists                                 ? running_floor_
                   : first_frame_ && params_.keep_first_frame ? first_frame_floor_
                                                              : floor_before_map_;
    floor.apply(view_, verdict_);
    first_frame_ = false;
    detections_.reset(), mask_.reset();
    finish();
    return true;
  }

  /// Frame numbers that start again are another run.
  void note_restart(std::int64_t id) {
    if (last_id_ && id < *last_id_) reset();
    last_id_ = id;
  }

  /// The same frame as before, thinned by now, with the host's pose. Of another frame the images are not
  /// ours.
  template <class Frame>
  FrameView view_of_known(const Frame& frame) {
    const bool known = last_id_ && *last_id_ == static_cast<std::int64_t>(frame.mnId);
    FrameView view =
        reader_.read(frame, known ? grey_ : cv::Mat(), known ? depth_ : cv::Mat(), depth_unit_m_);
    if (const std::optional<Pose> T_camera_world = orb_slam::camera_from_world(frame))
      view.T_world_camera = inverse(*T_camera_world), view.pose_provenance = PoseProvenance::Estimated;
    return view;
  }

  void add_semantics(FrameView& view) const {
    if (detections_) view.detections = DetectionInput{detections_frame_id_, *detections_};
    if (mask_) view.mask = *mask_;
  }

  void judge(const FrameView& view, CallPoint point) {
    view_ = view;
    keypoints_.assign(view.keypoints.begin(), view.keypoints.end());
    verdict_ = pipeline_.process(view, point);
  }
  void finish() {
    verdict_.report.rejected = verdict_.size() - verdict_.kept();
    view_ = FrameView();  // the host's memory is not looked at after the call
  }
  const Verdict& nothing_judged() {
    verdict_ = Verdict();
    keypoints_.clear();
    return verdict_;
  }

  OrbSlamParams params_;
  Pipeline pipeline_;
  Floor running_floor_, floor_before_map_, first_frame_floor_;
  orb_slam::FrameReader reader_;
  orb_slam::KeyframeReader keyframe_reader_;
  FrameView view_;
  Verdict verdict_;
  std::vector<cv::KeyPoint> keypoints_;
  cv::Mat grey_, depth_;  ///< the host's, for the later call points of the same frame
  double depth_unit_m_ = 1;
  std::optional<std::vector<Detection>> detections_;
  std::int64_t detections_frame_id_ = -1;
  std::optional<MaskInput> mask_;
  std::optional<std::int64_t> last_id_;
  bool first_frame_ = true;
};

}  // namespace dynfilter
