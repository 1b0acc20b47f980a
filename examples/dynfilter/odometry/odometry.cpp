// SPDX-License-Identifier: MIT
#include "odometry.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <deque>
#include <utility>

#include "mapper.hpp"
#include "orb_extractor.hpp"
#include "stereo_matcher.hpp"
#include "stopwatch.hpp"
#include "tracker.hpp"

namespace dynfilter::odometry {

class Odometry::Steps {
 public:
  Steps(const Camera& camera, const OdometryOptions& options, FeatureJudge* judge)
      : camera_(camera),
        options_(options),
        extractor_(options.extractor),
        stereo_(options.extractor, options.stereo),
        mapper_(pinhole(), options),
        tracker_(pinhole(), options),
        two_views_(pinhole(), options.start),
        gate_(options, judge) {}

  TrackResult process(const io::SequenceFrame& frame, const SemanticInputs& inputs,
                      const std::optional<Pose>& known) {
    TrackResult result;
    result.frame_id = next_frame_id_++;
    result.timestamp_s = frame.timestamp_s;
    Stopwatch watch;
    result.time_jump = jumped(frame.timestamp_s);
    if (result.time_jump) after_jump();
    extract(frame);
    result.features = static_cast<int>(features_.size());
    watch.lap(result, &StageTimes::extraction);

    gate_.begin(result.frame_id, frame, camera_, inputs, features_.size());
    pose_is_known_ = known.has_value();
    const std::optional<Eigen::Isometry3d> predicted =
        known ? known->isometry().inverse() : tracker_.predict(frame.timestamp_s);
    gate_.before_pose(features_, predicted);
    watch.lap(result, &StageTimes::judge);

    if (!options_.poses) {
      result.state = TrackState::Judged;
    } else if (known) {
      follow(*predicted, result, watch);
    } else if (mapper_.map().keyframes.empty()) {
      start_map(result, watch);
    } else {
      track(predicted, result, watch);
    }
    finish(result);
    return result;
  }

  std::vector<io::StampedPose> trajectory() const {
    std::vector<io::StampedPose> poses = settled_;
    for (const Anchored& a : anchored_) poses.push_back(posed(a));
    return poses;
  }

  const FrameFeatures& features() const { return features_; }

  const std::vector<cv::KeyPoint>& extracted() const { return gate_.extracted(); }
  const std::vector<RejectedAt>& rejected_at() const { return gate_.rejected_at(); }
  const Map& map() const { return mapper_.map(); }

 private:
  struct Anchored {
    double timestamp_s;
    std::int32_t keyframe;                ///< -1: the world
    Eigen::Isometry3d T_camera_keyframe;  ///< or T_camera_world
  };

  io::StampedPose posed(const Anchored& a) const {
    return {a.timestamp_s, Pose::from(in_world(a).inverse())};
  }
  Eigen::Isometry3d in_world(const Anchored& a) const {
    if (a.keyframe < 0) return a.T_camera_keyframe;
    return a.T_camera_keyframe * mapper_.map().keyframes[a.keyframe].T_camera_world;
  }

  /// Poses of its frames no longer change.
  void remove_oldest_keyframe() {
    const std::int32_t oldest = mapper_.map().keyframes.first();
    for (Anchored& a : anchored_)
      if (a.keyframe == oldest) a = {a.timestamp_s, -1, in_world(a)};
    for (; !anchored_.empty() && anchored_.front().keyframe < 0; anchored_.pop_front())
      settled_.push_back(posed(anchored_.front()));
    mapper_.map().remove_oldest_keyframe();
  }

  Pinhole pinhole() const {
    return Pinhole(camera_, options_.sensor == Sensor::Stereo ? camera_.baseline_fx_px_m
                                                              : options_.depth.baseline_fx_px_m);
  }

  bool jumped(double timestamp_s) const {
    return next_frame_id_ > 1 && !(std::abs(timestamp_s - last_timestamp_s_) <= options_.max_time_gap_s);
  }
  void after_jump() {
    tracker_.forget_motion();
    gate_.reset();
  }

  void extract(const io::SequenceFrame& frame) {
    extractor_.extract(frame.grey, features_.keypoints, features_.descriptors);
    undistort(camera_, features_.keypoints, features_.keypoints_undistorted);
    measure_depth(frame);
    features_.map_point.assign(features_.size(), -1);
    features_.spread.assign(features_.size(), {});
    features_.extracted.resize(features_.size());
    for (std::size_t i = 0; i < features_.size(); ++i) features_.extracted[i] = static_cast<std::int32_t>(i);
    image_ = frame.grey.size();
    tracker_.set_image(image_);
  }

  void measure_depth(const io::SequenceFrame& frame) {
    if (options_.sensor == Sensor::Stereo)
      stereo_.match(extractor_, frame.right, camera_.fx_px, camera_.baseline_fx_px_m, features_);
    else
      sample_depth(options_.sensor == Sensor::Rgbd ? frame.depth : cv::Mat(), frame.depth_unit_m,
                   options_.depth, features_.keypoints, features_.depth_m);
  }

  bool can_start_map() const {
    int with_depth = 0;
    for (const float depth_m : features_.depth_m) with_depth += depth_m > 0;
    return with_depth >= options_.min_initial_points && !gate_.wait_for_keyframe();
  }
  void start_map(TrackResult& result, Stopwatch& watch) {
    if (options_.sensor == Sensor::Mono) return start_from_two_views(result, watch);
    if (!can_start_map()) return;
    pose_ = Eigen::Isometry3d::Identity();
    result.state = TrackState::Tracked;
    make_keyframe(result, watch);
  }

  void start_from_two_views(TrackResult& result, Stopwatch& watch) {
    if (gate_.wait_for_keyframe()) return;
    const auto start = two_views_.add(result.frame_id, features_, image_);
    watch.lap(result, &StageTimes::tracking);
    if (!start) return;
    pose_ = start->T_current_reference;
    gate_.at_keyframe(features_, pose_, mapper_.map());
    watch.lap(result, &StageTimes::judge);
    const std::int32_t index = mapper_.start(*start, result.frame_id, features_);
    result.state = TrackState::Tracked;
    settle_keyframe(index, pose_, result, watch);
  }

  // A mono map that is lost soon after its start is not worth a return.
  bool map_is_young() const {
    return options_.sensor == Sensor::Mono &&
           static_cast<int>(mapper_.map().keyframes.size()) <= options_.start.young_keyframes;
  }
  void start_again() {
    mapper_.clear();
    tracker_ = Tracker(pinhole(), options_);
    tracker_.set_image(image_);
    two_views_.reset();
    anchored_.clear();
    settled_.clear();
    gate_.lost();
  }

  void track(const std::optional<Eigen::Isometry3d>& predicted, TrackResult& result, Stopwatch& watch) {
    Map& map = mapper_.map();
    tracker_.index(features_);
    bool found = predicted && tracker_.track_last_frame(map, *predicted, features_, pose_);
    if (!found) {
      found = tracker_.recover(map, features_, pose_);
      result.relocalised = found;
    }
    watch.lap(result, &StageTimes::tracking);
    if (found) {
      gate_.after_pose(features_, pose_, map);
      watch.lap(result, &StageTimes::judge);
      tracker_.index(features_);
      result.tracked_points = tracker_.track_local_map(mapper_, features_, pose_);
      found = result.tracked_points >=
              (result.relocalised ? options_.min_relocalised_inliers : options_.min_inliers);
      watch.lap(result, &StageTimes::tracking);
    }
    result.relocalised = result.relocalised && found;
    result.state = found ? TrackState::Tracked : TrackState::Lost;
    if (found && tracker_.needs_keyframe(map, features_, pose_, result)) make_keyframe(result, watch);
  }

  // Matches determine the visible map points and do not change the pose.
  void follow(const Eigen::Isometry3d& pose, TrackResult& result, Stopwatch& watch) {
    Map& map = mapper_.map();
    pose_ = pose;
    result.state = TrackState::Tracked;
    Eigen::Isometry3d fitted = pose;
    tracker_.index(features_);
    if (!map.keyframes.empty()) tracker_.track_last_frame(map, pose, features_, fitted);
    watch.lap(result, &StageTimes::tracking);
    gate_.after_pose(features_, pose_, map);
    watch.lap(result, &StageTimes::judge);
    if (map.keyframes.empty()) {
      if (can_start_map()) make_keyframe(result, watch);
      return;
    }
    tracker_.index(features_);
    fitted = pose;
    result.tracked_points = tracker_.track_local_map(mapper_, features_, fitted);
    watch.lap(result, &StageTimes::tracking);
    if (tracker_.needs_keyframe(map, features_, pose_, result)) make_keyframe(result, watch);
  }

  void make_keyframe(TrackResult& result, Stopwatch& watch) {
    gate_.at_keyframe(features_, pose_, mapper_.map());
    watch.lap(result, &StageTimes::judge);
    const Eigen::Isometry3d before = pose_;
    const std::int32_t index = mapper_.insert(result.frame_id, features_, pose_);
    if (options_.sensor == Sensor::Mono) mapper_.triangulate();
    settle_keyframe(index, before, result, watch);
  }

  void settle_keyframe(std::int32_t index, const Eigen::Isometry3d& before, TrackResult& result,
                       Stopwatch& watch) {
    mapper_.refine(!pose_is_known_);
    pose_ = mapper_.map().keyframes[index].T_camera_world;
    features_.map_point = mapper_.map().keyframes[index].features.map_point;
    tracker_.keyframe_made(mapper_.map(), index, before);
    result.keyframe = true;
    if (result.tracked_points == 0) result.tracked_points = tracker_.keyframe_points();
    while (static_cast<int>(mapper_.map().keyframes.count()) > options_.max_keyframes)
      remove_oldest_keyframe();
    watch.lap(result, &StageTimes::mapping);
  }

  void finish(TrackResult& result) {
    result.rejected = gate_.rejected();
    last_timestamp_s_ = result.timestamp_s;
    if (result.state == TrackState::Judged) return;
    const bool tracked = result.state == TrackState::Tracked;
    if (tracked) {
      result.T_world_camera = Pose::from(pose_.inverse());
      gate_.done(pose_);
      anchored_.push_back(anchored(result.timestamp_s));
    }
    if (result.state == TrackState::Lost && map_is_young()) return start_again();
    const bool newly_lost = tracker_.frame_done(tracked, result.timestamp_s, features_, pose_);
    if (newly_lost || result.relocalised) gate_.lost();
  }

  Anchored anchored(double timestamp_s) const {
    if (pose_is_known_) return {timestamp_s, -1, pose_};
    const std::int32_t keyframe = tracker_.reference_keyframe();
    const Eigen::Isometry3d T_world_keyframe = mapper_.map().keyframes[keyframe].T_camera_world.inverse();
    return {timestamp_s, keyframe, pose_ * T_world_keyframe};
  }

  Camera camera_;
  OdometryOptions options_;
  OrbExtractor extractor_;
  StereoMatcher stereo_;
  Mapper mapper_;
  Tracker tracker_;
  TwoViewStart two_views_;
  JudgeGate gate_;
  FrameFeatures features_;
  cv::Size image_;
  Eigen::Isometry3d pose_ = Eigen::Isometry3d::Identity();  ///< T_camera_world of this frame
  std::vector<io::StampedPose> settled_;                    ///< of the oldest frames
  std::deque<Anchored> anchored_;                           ///< of the others
  std::int64_t next_frame_id_ = 0;
  double last_timestamp_s_ = 0;
  bool pose_is_known_ = false;
};

Odometry::Odometry(const Camera& camera, const OdometryOptions& options, FeatureJudge* judge)
    : steps_(std::make_unique<Steps>(camera, options, judge)) {}
Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

TrackResult Odometry::process(const io::SequenceFrame& frame, const SemanticInputs& inputs,
                              const std::optional<Pose>& known) {
  return steps_->process(frame, inputs, known);
}
std::vector<io::StampedPose> Odometry::trajectory() const {
  return steps_->trajectory();
}
const FrameFeatures& Odometry::features() const {
  return steps_->features();
}
const std::vector<cv::KeyPoint>& Odometry::extracted() const {
  return steps_->extracted();
}
const std::vector<RejectedAt>& Odometry::rejected_at() const {
  return steps_->rejected_at();
}
const Map& Odometry::map() const {
  return steps_->map();
}

}  // namespace dynfilter::odometry
