// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/hosts/draw_verdict.hpp>
#include <dynfilter/hosts/host_semantics.hpp>
#include <dynfilter/hosts/input_watch.hpp>
#include <dynfilter/hosts/orb_slam/compact_frame.hpp>
#include <dynfilter/hosts/orb_slam/read_frame.hpp>
#include <dynfilter/hosts/orb_slam/settings.hpp>

namespace dynfilter {

/// Judges and thins the frames of an ORB-SLAM2 or ORB-SLAM3 fork (docs/how-to/orb_slam.md). A member of the
/// host's Tracking, called from its thread only; templates on the host's own types, told apart at compile
/// time.
///
/// Odd data never throws: images of a new size, no depth, an empty pose, no features. Time that jumps back
/// and a frame number that starts again reset the history. Wrong settings throw ConfigError when it is made.
/// Reading and thinning cost less than 0.1 ms for 1000 features, copies of images 0.12 ms for 640x480. A
/// depth image that is handed over is not copied.
class OrbSlam {
 public:
  /// Receives one line for the host's log, called from the thread of the call that has something to say.
  using LineSink = std::function<void(const std::string& line)>;

  /// For the host's constructor. Tells start_line(), later a warning when an input never came or a detector
  /// fails. Never throws: of settings that cannot be used it tells the error and, as `DynFilter.on_error`
  /// says, returns null or one that lets every feature through. `sensor`: the host's System::eSensor.
  static std::unique_ptr<OrbSlam> start(const std::string& settings_file, int sensor, LineSink sink,
                                        const Registry& registry = builtin_filters(),
                                        const ProviderRegistry& providers = {});

  /// The same for hosts that handle exceptions: throws ConfigError.
  OrbSlam(const std::string& settings_file, int sensor, const Registry& registry = builtin_filters(),
          const ProviderRegistry& providers = {})
      : OrbSlam(read_orb_slam_settings(settings_file, registry, providers), host_sensor(sensor)) {}
  /// The same with settings that were read before; `sink` gets the lines.
  OrbSlam(OrbSlamSettings settings, HostSensor sensor, LineSink sink = nullptr);

  // ---- what a detector or a segmenter found, for all call points of the next frame
  /// `frame_id`: the host's mnId of the frame they were computed on, or -1 for the next one. An empty list
  /// means that nothing was found. Masks inside are copied unless nothing else refers to them.
  void set_detections(std::vector<Detection> detections, std::int64_t frame_id = -1) {
    semantics_.set_detections(std::move(detections), frame_id);
  }
  /// CV_8UC1, 0 = background. Copied.
  void set_mask(const cv::Mat& labels, std::int64_t frame_id = -1) { semantics_.set_mask(labels, frame_id); }
  /// The next frame's colour image (CV_8UC3, BGR) for `DynFilter.detector`, which sees the grey one
  /// otherwise. Copied.
  void set_detector_image(const cv::Mat& colour) {
    keep_copy(colour, detector_image_);
    has_detector_image_ = true;
  }

  /// What the next frame's sensors say of the camera's motion since the last one, e.g. a gyroscope.
  void set_motion_prior(const MotionPrior& prior) { motion_prior_ = prior; }

  /// The next frame's right image, rectified, in which features without a column are searched. Copied.
  void set_right_image(const cv::Mat& right_grey) { keep_copy(right_grey, right_grey_), right_given_ = true; }

  // ---- the call points
  /// Beside the extraction, in a thread of its own that ends before the next call: Pipeline::prepare().
  void prepare(const cv::Mat& grey, double timestamp_s) {
    if (params_.enabled) pipeline_.prepare(grey, timestamp_s);
  }

  /// A: in the Frame's constructor, after the extraction and before `N` is set. Thins mvKeys and
  /// mDescriptors.
  template <class Frame>
  const Verdict& after_extraction(Frame& frame, const cv::Mat& grey, cv::Mat depth, bool map_exists) {
    if (!judge_first(frame, grey, std::move(depth), map_exists, {})) return verdict_;
    orb_slam::compact_extracted(frame.mvKeys, frame.mDescriptors, verdict_);
    return verdict_;
  }

  /// B: in GrabImage..., after the Frame is made and before Track(). `grey`: CV_8UC1. `depth`: CV_32FC1 in
  /// metres or CV_16UC1 with `depth_unit_m`, empty for one camera or two. With std::move() it is handed over,
  /// and kept without a copy if its memory has no other owner. `map_exists`: the host is past its
  /// initialisation (`mState >= OK`). `pose`: orb_slam::predicted_pose(mVelocity, mLastFrame), or nothing.
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
    judge(view_of_known(frame), CallPoint::AfterPose, params_.min_features);
    orb_slam::compact_frame(frame, verdict_);
    return verdict_;
  }

  /// In CreateNewKeyFrame, before the KeyFrame is made of the frame. Judges features and map points, those of
  /// the covisible keyframes (mvpLocalKeyFrames) as well, and thins the frame. Returns the map points that
  /// moved, for the host to erase (SetBadFlag).
  template <class Frame, class KeyFrame>
  std::vector<orb_slam::MapPointOf<Frame>*> at_keyframe(Frame& frame,
                                                        const std::vector<KeyFrame*>& keyframes) {
    std::vector<orb_slam::MapPointOf<Frame>*> moved;
    if (!params_.enabled) return moved;
    FrameView view = view_of_known(frame);
    if (!orb_slam::is_fisheye(frame))
      view.covisible_keyframes = keyframe_reader_.read(keyframes, OrbSlamParams::kCovisibleKeyframes);
    judge(view, CallPoint::AtKeyframe, params_.min_features);
    for (std::size_t i = 0; i < verdict_.size() && i < frame.mvpMapPoints.size(); ++i)
      if (!verdict_.keep(i) && frame.mvpMapPoints[i] != nullptr) moved.push_back(frame.mvpMapPoints[i]);
    orb_slam::compact_frame(frame, verdict_);
    const std::vector<std::int64_t> ids = pipeline_.moved_map_points();
    for (KeyFrame* const keyframe : keyframes)
      if (!ids.empty() && keyframe != nullptr && !keyframe->isBad())
        for (auto* const point : keyframe->GetMapPointMatches())
          if (point != nullptr && std::binary_search(ids.begin(), ids.end(), orb_slam::id_of(*point)))
            moved.push_back(point);
    std::sort(moved.begin(), moved.end());
    moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
    return moved;
  }

  /// Whether a map point has moved, for candidates of loops and of relocalisation. From any thread.
  template <class MapPoint>
  bool moved(const MapPoint* point) const {
    return point != nullptr && pipeline_.map_point(orb_slam::id_of(*point)).vote == Vote::Dynamic;
  }

  /// In Tracking::Track, while the host is lost: forgets its poses, and ignores that of this frame. Images,
  /// tracks and verdicts on map points stay, because the map does.
  void lost() { pipeline_.lost(), lost_ = true; }
  void reset();  ///< in Tracking::Reset: forgets everything; the next frame is a first frame

  // ---- what happened
  /// Of the last call; in the order of judged_keypoints(), which is the host's order before it was thinned.
  const Verdict& verdict() const { return verdict_; }
  /// As the host had them before it was thinned [px].
  const std::vector<cv::KeyPoint>& judged_keypoints() const { return keypoints_; }
  /// Verdict::weight per feature of the frame as it is now, of before_tracking or after_extraction. The
  /// host's optimiser multiplies mvInvLevelSigma2 with it and divides by it in its test of outliers. Empty
  /// while the filter is off.
  const std::vector<float>& weights() const { return weights_; }
  std::string summary() const { return summary_line(verdict_.report); }  ///< one line on the last frame
  /// See draw_verdict(): red is rejected.
  cv::Mat draw(const cv::Mat& image) const { return draw_verdict(image, keypoints_, verdict_); }
  const OrbSlamParams& params() const { return params_; }
  /// The pipeline that runs: its name, its stages, what it needs.
  const Pipeline& pipeline() const { return pipeline_; }
  /// The file that the pipeline was read from: the settings file or a preset's; "" if made in code.
  const std::string& pipeline_file() const { return pipeline_file_; }
  /// Which pipeline runs, from which file, which inputs it uses and which of them this host gives.
  std::string start_line() const {
    return params_.enabled ? watch_.start_line(pipeline_file_, given_inputs())
                           : "dynfilter: off, every feature is kept (DynFilter.enabled)";
  }
  /// The last line that was told, start_line() excepted; "" if there was none.
  const std::string& warning() const { return warning_; }
  /// Metres per unit of a CV_16UC1 depth image.
  void set_depth_unit_m(double depth_unit_m) { depth_unit_m_ = depth_unit_m; }

 private:
  static std::unique_ptr<OrbSlam> after_error(const std::string& settings_file, HostSensor sensor,
                                              LineSink sink, const std::string& what);
  void print(const std::string& line) const {
    if (sink_) sink_(line);
  }
  void warn(const std::string& line);
  Input given_inputs() const;  ///< as far as it is known before the first frame

  /// Features that the host's tracker needs, more while it has no map.
  int min_features(bool map_exists) const;

  template <class Frame>
  bool judge_first(const Frame& frame, const cv::Mat& grey, cv::Mat&& depth, bool map_exists,
                   const orb_slam::HostPose& pose) {
    if (!params_.enabled) {
      nothing_judged();
      return false;
    }
    note_restart(static_cast<std::int64_t>(frame.mnId));
    const bool handed_over = has_sole_owner(depth);
    keep_images(grey, std::move(depth));
    if (!std::exchange(right_given_, false) || sensor_ != HostSensor::Stereo) right_grey_.release();
    FrameView view = reader_.read(frame, grey_, depth_, depth_unit_m_, sensor_ == HostSensor::Stereo);
    view.right_grey = right_grey_, view.depth_handed_over = handed_over;
    view.motion_prior = std::exchange(motion_prior_, std::nullopt);
    take_pose(pose, map_exists, view);
    submit_to_detector(view);
    semantics_.add_to(view);
    judge(view, CallPoint::BeforePose, min_features(map_exists));
    first_frame_ = false;
    return true;
  }

  /// For the later call points of the same frame, when the host may have freed its images.
  void keep_images(const cv::Mat& grey, cv::Mat&& depth) {
    keep_copy(grey, grey_);
    if (has_sole_owner(depth)) return void(depth_ = std::move(depth));
    keep_copy(depth, depth_);
  }

  void take_pose(const orb_slam::HostPose& pose, bool map_exists, FrameView& view);
  void submit_to_detector(const FrameView& view);

  void note_restart(std::int64_t id);  ///< frame numbers that start again are another run

  /// The same frame, thinned by now, with the host's pose. Of another frame the images are not ours.
  template <class Frame>
  FrameView view_of_known(const Frame& frame) {
    const bool known = last_id_ && *last_id_ == static_cast<std::int64_t>(frame.mnId);
    FrameView view = reader_.read(frame, known ? grey_ : cv::Mat(), known ? depth_ : cv::Mat(), depth_unit_m_,
                                  sensor_ == HostSensor::Stereo);
    if (known) view.right_grey = right_grey_, semantics_.add_to(view);
    if (const std::optional<Pose> T_camera_world = orb_slam::camera_from_world(frame))
      view.T_world_camera = inverse(*T_camera_world), view.pose_provenance = PoseProvenance::Estimated;
    return view;
  }

  void judge(const FrameView& view, CallPoint point, int min_features);
  void reject_moved_points(const FrameView& view);  ///< at a keyframe, which would hand them on
  const Verdict& nothing_judged();

  OrbSlamParams params_;
  HostSensor sensor_;
  LineSink sink_;
  std::string pipeline_file_, warning_;
  HostSemantics semantics_;
  Pipeline pipeline_;
  InputWatch watch_;
  orb_slam::FrameReader reader_;
  orb_slam::KeyframeReader keyframe_reader_;
  Verdict verdict_;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<float> weights_;
  cv::Mat grey_, depth_, right_grey_;  ///< of the last frame
  cv::Mat detector_image_;
  bool has_detector_image_ = false, right_given_ = false;  ///< for the next frame
  double depth_unit_m_ = 1;
  std::optional<MotionPrior> motion_prior_;  ///< of the next frame
  std::optional<std::int64_t> last_id_;
  bool first_frame_ = true, lost_ = false;
  std::vector<std::int64_t> point_ids_;  ///< of the host's last frame
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/detail/orb_slam-inl.hpp>
#endif
