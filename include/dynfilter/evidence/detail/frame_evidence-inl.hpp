// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/frame_evidence.hpp>

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <dynfilter/evidence/history.hpp>
#include <dynfilter/evidence/late_results.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <list>
#include <optional>
#include <vector>

namespace dynfilter {

/// Models fitted to the matches of one frame, each once for the same match and seeds.
class FrameModels {
 public:
  /// Refers to `current`, which must outlive it.
  explicit FrameModels(CurrentFrame& current) : current_(current) {}

  void begin();

  /// See Evidence::two_view().
  const TwoViewModel& two_view(const Match& match, const std::vector<int>& seeds);
  /// `prior`: a T_current_reference that competes as a hypothesis.
  const RigidMotion& rigid_motion(const Match& match, const std::vector<int>& seeds,
                                  const std::optional<Pose>& prior);

 private:
  template <class Model>
  struct Fitted {
    bool valid = false;
    const Match* match = nullptr;
    std::vector<int> seeds;
    Model model;
  };
  template <class Model, class Fit>
  static const Model& fitted(std::list<Fitted<Model>>& known, const Match& match,
                             const std::vector<int>& seeds, const Fit& fit);

  CurrentFrame& current_;
  TwoViewEstimator two_view_;
  RigidMotionEstimator rigid_motion_;
  std::list<Fitted<TwoViewModel>> two_views_;
  std::list<Fitted<RigidMotion>> rigid_motions_;
};

DYNFILTER_INLINE void FrameModels::begin() {
  detail::free_slots(two_views_);
  detail::free_slots(rigid_motions_);
}

DYNFILTER_INLINE const TwoViewModel& FrameModels::two_view(const Match& match,
                                                           const std::vector<int>& seeds) {
  return fitted(two_views_, match, seeds, [&] {
    const FrameView& frame = current_.frame();
    return two_view_.estimate(match.reference_undistorted_px, current_.undistorted_pixels(), seeds,
                              frame.camera ? &*frame.camera : nullptr);
  });
}

DYNFILTER_INLINE const RigidMotion& FrameModels::rigid_motion(const Match& match,
                                                              const std::vector<int>& seeds,
                                                              const std::optional<Pose>& prior) {
  return fitted(rigid_motions_, match, seeds, [&] {
    rigid_motion_.options().depth_noise = depth_noise_of(current_.frame());
    return rigid_motion_.estimate(current_.frame().camera.value_or(Camera()), match.reference_points_m,
                                  current_.points_m(), seeds, prior);
  });
}

template <class Model, class Fit>
const Model& FrameModels::fitted(std::list<Fitted<Model>>& known, const Match& match,
                                 const std::vector<int>& seeds, const Fit& fit) {
  for (const Fitted<Model>& slot : known)
    if (slot.valid && slot.match == &match && slot.seeds == seeds) return slot.model;
  Fitted<Model>& slot = detail::next_slot(known);
  slot.match = &match;
  slot.seeds = seeds;
  slot.model = fit();
  return slot.model;
}

/// The features' tracks, chained once per frame for each set of options. Hosts compact the frame between call
/// points, so each call point has its own.
class FrameTracks {
 public:
  /// Refers to both, which must outlive it.
  FrameTracks(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

  /// See Evidence::tracks(); extends them once per frame.
  const FeatureTracks& tracks(const TrackOptions& options, CallPoint call_point);
  void reset();

 private:
  struct Chain {
    CallPoint call_point;
    FeatureTracks tracks;
  };
  FeatureTracks& with(const TrackOptions& options, CallPoint call_point);

  CurrentFrame& current_;
  FrameMatches& matches_;
  std::list<Chain> all_;  ///< a list, because filters hold references
};

DYNFILTER_INLINE const FeatureTracks& FrameTracks::tracks(const TrackOptions& options, CallPoint call_point) {
  FeatureTracks& tracks = with(options, call_point);
  if (tracks.last_id() == current_.frame().id && tracks.size() == current_.size()) return tracks;
  static const std::vector<float> kNoDepths;
  tracks.follow(current_.frame().id, matches_.match({}), current_.pixels(), current_.undistorted_pixels(),
                options.use_depth ? current_.depths_m() : kNoDepths);
  return tracks;
}

DYNFILTER_INLINE void FrameTracks::reset() {
  for (Chain& chain : all_) chain.tracks.reset();
}

DYNFILTER_INLINE FeatureTracks& FrameTracks::with(const TrackOptions& options, CallPoint call_point) {
  for (Chain& chain : all_)
    if (chain.call_point == call_point && chain.tracks.options() == options) return chain.tracks;
  all_.push_back({call_point, FeatureTracks(options)});
  return all_.back().tracks;
}

/// Each computes on first use, which a reader of evidence does not see as a change.
struct FrameEvidence::Owners {
  explicit Owners(const CorrespondenceParams& p) : params(p) { check_parameters(p, "correspondence"); }

  CorrespondenceParams params;
  CurrentFrame current{params.max_depth_m, DepthSampler::kMaxDepthEdge};
  FrameMatches matches{params, current};
  FrameModels models{current};
  FrameTracks tracks{current, matches};
  LateResults late{current, matches};
};

DYNFILTER_INLINE FrameEvidence::FrameEvidence(const CorrespondenceParams& params)
    : owners_(std::make_unique<Owners>(params)) {}
DYNFILTER_INLINE FrameEvidence::~FrameEvidence() = default;

DYNFILTER_INLINE void FrameEvidence::begin(const FrameView& frame, CallPoint call_point) {
  call_point_ = call_point;
  owners_->current.begin(frame);
  earlier_votes_.begin(owners_->current.pixels());
  owners_->models.begin();
  owners_->late.begin(owners_->matches.begin());
}

DYNFILTER_INLINE void FrameEvidence::end(bool keyframe) {
  owners_->late.end();
  if (keyframe) owners_->matches.history().mark_keyframe();
  owners_->current.end();
}

DYNFILTER_INLINE void FrameEvidence::reset() {
  owners_->matches.reset();
  owners_->tracks.reset();
  owners_->late.reset();
}

DYNFILTER_INLINE void FrameEvidence::update_pose(std::int64_t frame_id, const Pose& T_world_camera,
                                                 PoseProvenance provenance) {
  StoredFrame* stored = owners_->matches.history().find(frame_id);
  if (stored == nullptr || !is_rigid(T_world_camera)) return;
  stored->T_world_camera = T_world_camera;
  stored->pose_provenance = provenance;
}

DYNFILTER_INLINE void FrameEvidence::collect_seeds(const Match& match, bool all,
                                                   std::vector<int>& seeds) const {
  seeds.clear();
  const Span<const std::uint8_t> seed = earlier_votes_.seed();
  for (std::size_t i = 0; i < size(); ++i)
    if (match.found(i) && (all || seed[i] != 0)) seeds.push_back(static_cast<int>(i));
}

DYNFILTER_INLINE std::optional<Pose> FrameEvidence::host_motion(const Match& match) const {
  const FrameView& now = frame();
  if (match.reference == nullptr || now.pose_provenance == PoseProvenance::None ||
      match.reference->pose_provenance == PoseProvenance::None)
    return std::nullopt;
  return inverse(now.T_world_camera) * match.reference->T_world_camera;
}

DYNFILTER_INLINE std::optional<MotionPrior> FrameEvidence::motion_prior(const Match& match) const {
  const MotionPrior* prior = owners_->matches.motion_prior(match.reference);
  return prior != nullptr ? std::optional<MotionPrior>(*prior) : std::nullopt;
}

DYNFILTER_INLINE void FrameEvidence::set_history(int frames) {
  owners_->matches.history().set_capacity(frames);
}
DYNFILTER_INLINE void FrameEvidence::set_semantics(bool used) {
  owners_->late.set_used(used);
}
DYNFILTER_INLINE void FrameEvidence::prepare(const cv::Mat& grey, double timestamp_s) {
  owners_->matches.prepare(grey, timestamp_s);
}
DYNFILTER_INLINE bool FrameEvidence::prepared_in_vain() const {
  return owners_->matches.prepared_in_vain();
}
DYNFILTER_INLINE void FrameEvidence::forget_poses() {
  owners_->matches.history().forget_poses();
}
DYNFILTER_INLINE void FrameEvidence::set_clock(double (*clock_ms)()) {
  owners_->matches.set_clock(clock_ms);
}
DYNFILTER_INLINE double FrameEvidence::correspondence_ms() const {
  return owners_->matches.correspondence_ms();
}
DYNFILTER_INLINE const std::vector<std::string>& FrameEvidence::input_notes() const {
  return owners_->current.notes();
}
DYNFILTER_INLINE std::string FrameEvidence::take_match_note() {
  return owners_->matches.take_note();
}
DYNFILTER_INLINE const std::vector<MatchSpread>* FrameEvidence::spread() const {
  return owners_->matches.spread();
}
DYNFILTER_INLINE const FrameView& FrameEvidence::frame() const {
  return owners_->current.frame();
}
DYNFILTER_INLINE Input FrameEvidence::inputs() const {
  return owners_->current.inputs();
}
DYNFILTER_INLINE std::size_t FrameEvidence::size() const {
  return owners_->current.size();
}
DYNFILTER_INLINE const std::vector<cv::Point2f>& FrameEvidence::pixels() const {
  return owners_->current.pixels();
}
DYNFILTER_INLINE const std::vector<cv::Point2f>& FrameEvidence::undistorted_pixels() const {
  return owners_->current.undistorted_pixels();
}
DYNFILTER_INLINE const std::vector<float>& FrameEvidence::depths_m() const {
  return owners_->current.depths_m();
}
DYNFILTER_INLINE const std::vector<cv::Point3f>& FrameEvidence::points_m() const {
  return owners_->current.points_m();
}
DYNFILTER_INLINE const Match& FrameEvidence::match(const Reference& reference) const {
  return owners_->matches.match(reference);
}
DYNFILTER_INLINE const Match& FrameEvidence::second_look(const Match& match, const Pose& T_current_reference,
                                                         Span<const std::uint8_t> doubted) const {
  return owners_->matches.second_look(match, T_current_reference, doubted);
}
DYNFILTER_INLINE const Match& FrameEvidence::match_with(std::int64_t frame_id) const {
  return owners_->matches.match_with(frame_id);
}
DYNFILTER_INLINE const MatchedFeatures& FrameEvidence::matched_features(const Match& match,
                                                                        double max_offset_px) const {
  return owners_->matches.matched_features(match, max_offset_px);
}
DYNFILTER_INLINE const FeatureTracks& FrameEvidence::tracks(const TrackOptions& options) const {
  return owners_->tracks.tracks(options, call_point_);
}
DYNFILTER_INLINE const PastFrame* FrameEvidence::kept_frame(std::int64_t frame_id) const {
  return owners_->matches.history().find(frame_id);
}
DYNFILTER_INLINE const TwoViewModel& FrameEvidence::two_view(const Match& match,
                                                             const std::vector<int>& seeds) const {
  return owners_->models.two_view(match, seeds);
}
DYNFILTER_INLINE const RigidMotion& FrameEvidence::rigid_motion(const Match& match,
                                                                const std::vector<int>& seeds) const {
  return owners_->models.rigid_motion(match, seeds, host_motion(match));
}
DYNFILTER_INLINE const std::vector<Detection>* FrameEvidence::carried_boxes(int max_age_frames) const {
  return owners_->late.boxes(max_age_frames);
}
DYNFILTER_INLINE const cv::Mat* FrameEvidence::carried_labels() const {
  return owners_->late.labels();
}

}  // namespace dynfilter
