// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/earlier_votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <dynfilter/evidence/frame_models.hpp>
#include <dynfilter/evidence/frame_tracks.hpp>
#include <dynfilter/evidence/history.hpp>
#include <dynfilter/evidence/late_results.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

/// The evidence of one camera stream, frame after frame. A pipeline owns one; so may a test of a filter:
///
///     FrameEvidence evidence;
///     evidence.set_history(filter.needs().history_frames);
///     evidence.begin(frame, CallPoint::BeforePose);
///     votes.reset(evidence.size());
///     filter.apply(evidence, votes);
///     evidence.end(false);
///
/// The frame, its matches, models, tracks and late results have one owner each; this joins them.
class FrameEvidence final : public Evidence {
 public:
  /// Throws ConfigError.
  explicit FrameEvidence(const CorrespondenceParams& params = CorrespondenceParams());
  FrameEvidence(const FrameEvidence&) = delete;
  FrameEvidence& operator=(const FrameEvidence&) = delete;

  /// How many earlier frames to keep.
  void set_history(int frames) { matches_.history().set_capacity(frames); }
  /// Set if a stage reads boxes or masks. The motion that late ones are carried along is then recorded.
  void set_semantics(bool used) { late_.set_used(used); }

  void begin(const FrameView& frame, CallPoint call_point);
  /// The frame's memory is not read after this.
  void end(bool keyframe);
  /// Forgets all earlier frames.
  void reset();
  /// Does what needs no features of the next frame, see Pipeline::prepare().
  void prepare(const cv::Mat& grey, double timestamp_s) { matches_.prepare(grey, timestamp_s); }
  bool prepared_in_vain() const { return matches_.prepared_in_vain(); }  ///< for another image or stamp
  void forget_poses() { matches_.history().forget_poses(); }             ///< of all earlier frames
  /// Sets the pose of an earlier frame. Ignored if it is no longer kept, or not rigid.
  void update_pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance);

  /// For combinators.
  EarlierVotes& earlier_votes() { return earlier_votes_; }
  /// Milliseconds since some moment. Null: correspondence_ms() stays 0.
  void set_clock(double (*clock_ms)()) { matches_.set_clock(clock_ms); }
  /// Time for matches of this frame [ms]; 0 without a clock.
  double correspondence_ms() const { return matches_.correspondence_ms(); }
  /// Inputs that were present but unusable, e.g. "depth_m cannot be used: wrong size or type".
  const std::vector<std::string>& input_notes() const { return current_.notes(); }
  /// What was odd about the host's matches. Empty: nothing.
  std::string take_match_note() { return matches_.take_note(); }
  /// Of the match with the last frame. Null: nobody asked for that match.
  const std::vector<MatchSpread>* spread() const { return matches_.spread(); }

  const FrameView& frame() const override { return current_.frame(); }
  CallPoint call_point() const override { return call_point_; }
  Input inputs() const override { return current_.inputs(); }
  std::size_t size() const override { return current_.size(); }
  const std::vector<cv::Point2f>& pixels() const override { return current_.pixels(); }
  const std::vector<cv::Point2f>& undistorted_pixels() const override {
    return current_.undistorted_pixels();
  }
  const std::vector<float>& depths_m() const override { return current_.depths_m(); }
  const std::vector<cv::Point3f>& points_m() const override { return current_.points_m(); }

  using Evidence::called_dynamic;  ///< of one feature, too
  using Evidence::judged;          ///< of one feature, too
  using Evidence::prior;           ///< of one feature, too
  using Evidence::seed;            ///< of one feature, too
  Span<const std::uint8_t> judged() const override { return earlier_votes_.judged(); }
  Span<const std::uint8_t> prior() const override { return earlier_votes_.prior(); }
  Span<const std::uint8_t> seed() const override { return earlier_votes_.seed(); }
  Span<const std::uint8_t> called_dynamic() const override { return earlier_votes_.called_dynamic(); }

  const Match& match(const Reference& reference) const override { return matches_.match(reference); }
  const Match& match_with(std::int64_t frame_id) const override { return matches_.match_with(frame_id); }
  const MatchedFeatures& matched_features(
      const Match& match, double max_offset_px = MatchedFeatures::kMaxOffsetPx) const override {
    return matches_.matched_features(match, max_offset_px);
  }
  const FeatureTracks& tracks(const TrackOptions& options) const override {
    return tracks_.tracks(options, call_point_);
  }
  const PastFrame* kept_frame(std::int64_t frame_id) const override {
    return matches_.history().find(frame_id);
  }

  void collect_seeds(const Match& match, bool all, std::vector<int>& seeds) const override;
  const TwoViewModel& two_view(const Match& match, const std::vector<int>& seeds) const override {
    return models_.two_view(match, seeds);
  }
  const RigidMotion& rigid_motion(const Match& match, const std::vector<int>& seeds) const override {
    return models_.rigid_motion(match, seeds, host_motion(match));
  }
  std::optional<Pose> host_motion(const Match& match) const override;

  const std::vector<Detection>* carried_boxes(int max_age_frames) const override {
    return late_.boxes(max_age_frames);
  }
  const cv::Mat* carried_labels() const override { return late_.labels(); }

 private:
  static const CorrespondenceParams& checked(const CorrespondenceParams& params);

  CorrespondenceParams params_;
  CallPoint call_point_ = CallPoint::BeforePose;
  EarlierVotes earlier_votes_;
  // Computed on first use, which a reader of evidence does not see as a change.
  mutable CurrentFrame current_;
  mutable FrameMatches matches_;
  mutable FrameModels models_;
  mutable FrameTracks tracks_;
  mutable LateResults late_;
};

inline FrameEvidence::FrameEvidence(const CorrespondenceParams& params)
    : params_(checked(params)),
      current_(params.max_depth_m, DepthSampler::kMaxDepthEdge),
      matches_(params_, current_),
      models_(current_),
      tracks_(current_, matches_),
      late_(current_, matches_) {}

inline void FrameEvidence::begin(const FrameView& frame, CallPoint call_point) {
  call_point_ = call_point;
  current_.begin(frame);
  earlier_votes_.begin(current_.pixels());
  models_.begin();
  late_.begin(matches_.begin());
}

inline void FrameEvidence::end(bool keyframe) {
  late_.end();
  if (keyframe) matches_.history().mark_keyframe();
  current_.end();
}

inline void FrameEvidence::reset() {
  matches_.reset();
  tracks_.reset();
  late_.reset();
}

inline void FrameEvidence::update_pose(std::int64_t frame_id, const Pose& T_world_camera,
                                       PoseProvenance provenance) {
  StoredFrame* stored = matches_.history().find(frame_id);
  if (stored == nullptr || !is_rigid(T_world_camera)) return;
  stored->T_world_camera = T_world_camera;
  stored->pose_provenance = provenance;
}

inline void FrameEvidence::collect_seeds(const Match& match, bool all, std::vector<int>& seeds) const {
  seeds.clear();
  const Span<const std::uint8_t> seed = earlier_votes_.seed();
  for (std::size_t i = 0; i < size(); ++i)
    if (match.found(i) && (all || seed[i] != 0)) seeds.push_back(static_cast<int>(i));
}

inline std::optional<Pose> FrameEvidence::host_motion(const Match& match) const {
  const FrameView& now = frame();
  if (match.reference == nullptr || now.pose_provenance == PoseProvenance::None ||
      match.reference->pose_provenance == PoseProvenance::None)
    return std::nullopt;
  return inverse(now.T_world_camera) * match.reference->T_world_camera;
}

inline const CorrespondenceParams& FrameEvidence::checked(const CorrespondenceParams& params) {
  check_parameters(params, "correspondence");
  return params;
}

}  // namespace dynfilter
