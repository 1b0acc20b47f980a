// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <dynfilter/context/clean_frame.hpp>
#include <dynfilter/context/context_params.hpp>
#include <dynfilter/context/depth_sampler.hpp>
#include <dynfilter/context/history.hpp>
#include <dynfilter/context/late_semantics.hpp>
#include <dynfilter/context/match.hpp>
#include <dynfilter/context/matched_features.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/correspondence/host_match.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <limits>
#include <list>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// What filters read: the current frame, the votes of earlier stages and shared evidence.
/// Shared evidence is correspondences, 3-D points, two-view models and relative motion.
/// It is computed on first use, once per frame.
class Context {
  /// Result of the earlier stages, per feature.
  struct State {
    std::vector<std::uint8_t> judged, prior, seed, dynamic;
  };

 public:
  explicit Context(const ContextParams& params = ContextParams())
      : params_(params),
        flow_(params.flow),
        step_flow_(checked_once(params.flow)),
        descriptors_(params.descriptors) {
    check_parameters(params_, "correspondence");
  }

  // ---- the frame
  const FrameView& frame() const { return frame_; }
  CallPoint call_point() const { return call_point_; }
  Input inputs() const { return inputs_; }
  std::size_t size() const { return frame_.size(); }
  const History& history() const { return history_; }

  /// Distorted pixels, one per feature.
  const std::vector<cv::Point2f>& pixels() const { return pixels_; }
  /// Undistorted pixels: the host's, else computed with the camera, else the distorted ones.
  const std::vector<cv::Point2f>& undistorted_pixels() {
    if (!undistorted_ready_) fill_undistorted();
    return undistorted_;
  }
  /// Depth along the optical axis [m].
  /// NaN: no depth, beyond `max_depth_m`, or on a silhouette of the depth image.
  const std::vector<float>& depths_m() {
    if (!depths_ready_) fill_depths();
    return depths_m_;
  }
  /// Points in the frame of the current camera [m]. NaN without depth.
  const std::vector<cv::Point3f>& points_m() {
    if (!points_ready_) {
      points_m_.resize(size());
      back_project(frame_.camera.value_or(Camera()), undistorted_pixels(), depths_m(), points_m_);
      points_ready_ = true;
    }
    return points_m_;
  }

  // ---- result of earlier stages
  /// True if this stage judges feature i.
  /// A sequence passes on the survivors, a gate one side.
  bool judged(std::size_t i) const { return state_.judged[i] != 0; }
  /// The same for all features: 1 or 0 each.
  Span<const std::uint8_t> judged() const { return state_.judged; }
  /// True if a semantic stage marked feature i as a suspect.
  bool prior(std::size_t i) const { return state_.prior[i] != 0; }
  /// True if models may be fitted on feature i, because no earlier stage suspects it.
  bool seed(std::size_t i) const { return state_.seed[i] != 0; }
  /// True if an earlier stage of a sequence voted feature i dynamic. It is not judged again.
  bool called_dynamic(std::size_t i) const { return state_.dynamic[i] != 0; }
  bool any_prior() const {
    for (const std::uint8_t p : state_.prior)
      if (p != 0) return true;
    return false;
  }
  std::size_t count_judged() const {
    std::size_t n = 0;
    for (const std::uint8_t j : state_.judged) n += j;
    return n;
  }

  // ---- shared evidence
  /// Positions of the features in an earlier frame.
  /// Without that frame, no entry is found and `reference` is null.
  const Match& match(const Reference& reference) {
    const StoredFrame* stored = resolve(reference);
    last_asked_for_ = last_asked_for_ || stored == resolve(Reference());
    return match_stored(stored);
  }

  /// The same for the frame with this id, for results that arrive late.
  const Match& match_with(std::int64_t frame_id) { return match_stored(history_.find(frame_id)); }

  /// The reference frame's feature of each match, and the distance of their descriptors. `max_offset_px`: how
  /// far from the end of optical flow that feature may be.
  const MatchedFeatures& matched_features(const Match& match,
                                          double max_offset_px = MatchedFeatures::kMaxOffsetPx) {
    for (const MatchedFeatures& known : matched_features_)
      if (known.valid && known.is_of(match, max_offset_px)) return known;
    MatchedFeatures& matched = next_slot(matched_features_);
    matched.assign(frame_, match, max_offset_px);
    return matched;
  }

  /// The frame's boxes when they are of an older frame, carried to this one (context/late_semantics.hpp):
  /// those found on it or, missed since, at most `max_age_frames` ago, with track ids. Null when nothing
  /// leads here.
  const std::vector<Detection>* carried_boxes(int max_age_frames) {
    record_step();
    const std::vector<CarriedBox>* boxes = late_.boxes(*frame_.detections, frame_.id);
    if (boxes == nullptr) return nullptr;
    carried_.clear();
    const TrailFrame& now = *late_.trail().find(frame_.id);
    for (const CarriedBox& box : *boxes) {
      if (frame_.id - box.found_id > max_age_frames) continue;
      carried_.push_back(box.detection);
      if (!box.detection.mask.empty()) carried_.back().mask = carried_instance(box, now.image_px);
    }
    return &carried_;
  }
  /// A mask of an older frame, carried to this one, at a quarter of the image's width and height.
  /// Null if the trail does not reach this frame.
  const cv::Mat* carried_labels() {
    record_step();
    CarriedMask* mask = late_.mask(*frame_.mask, frame_.id);
    return mask == nullptr ? nullptr : &mask->labels();
  }

  /// The two-view model fitted on the seeds of a match (geometry/two_view.hpp).
  const TwoViewModel& two_view(const Match& match, const std::vector<int>& seeds) {
    return fitted(two_views_, match, seeds, [&] {
      return two_view_.estimate(match.reference_undistorted_px, undistorted_pixels(), seeds,
                                frame_.camera ? &*frame_.camera : nullptr);
    });
  }

  /// Camera motion since the match's reference, fitted on 3-D seeds (geometry/rigid_motion.hpp).
  /// A motion that the host predicts competes as a hypothesis.
  /// Otherwise a mover with most of the features would win.
  const RigidMotion& rigid_motion(const Match& match, const std::vector<int>& seeds) {
    return fitted(rigid_motions_, match, seeds, [&] {
      return rigid_motion_.estimate(frame_.camera.value_or(Camera()), match.reference_points_m, points_m(),
                                    seeds, host_motion(match));
    });
  }

  /// T_current_reference from the host's poses, if both frames have one.
  std::optional<Pose> host_motion(const Match& match) const {
    if (match.reference == nullptr || frame_.pose_provenance == PoseProvenance::None ||
        match.reference->pose_provenance == PoseProvenance::None)
      return std::nullopt;
    return inverse(frame_.T_world_camera) * match.reference->T_world_camera;
  }

  /// Features with a correspondence that may support a model.
  /// With `all`, the result of earlier stages is ignored.
  void collect_seeds(const Match& match, bool all, std::vector<int>& seeds) const {
    seeds.clear();
    for (std::size_t i = 0; i < size(); ++i)
      if (match.correspondences.found[i] != 0 && (all || seed(i))) seeds.push_back(static_cast<int>(i));
  }

  /// Adds text about the running stage to the frame's report.
  void note(const std::string& text) { note_ += (note_.empty() ? "" : "; ") + text; }
  std::string take_note() { return std::exchange(note_, {}); }

  // ---- which stages suspect a feature, whatever becomes of it in the pipeline
  void collect_suspicions(bool collect) {
    suspected_by_.assign(collect ? size() : 0, 0);
    collects_suspicions_ = collect;
  }
  bool collects_suspicions() const { return collects_suspicions_; }
  void suspect(std::size_t i, std::uint64_t stages) { suspected_by_[i] |= stages; }
  /// Bit k: stage k of the report. 0 unless they are collected.
  std::uint64_t suspected_by(std::size_t i) const { return collects_suspicions_ ? suspected_by_[i] : 0; }

  // ---- for combinators: state of the next stages
  void mark_prior(std::size_t i) { state_.prior[i] = 1, state_.seed[i] = 0; }
  /// Excludes feature i from judgement. It remains a seed.
  void excuse(std::size_t i) { state_.judged[i] = 0; }
  /// Applies the votes of an earlier stage. Its suspects are no longer seeds.
  /// Features that it rejected are neither judged again nor used for models.
  /// The loop has no branches because its conditions are unpredictable.
  void learn(const Votes& said) {
    const Vote* vote = said.votes().data();
    const std::uint8_t* suspect = said.priors().data();
    std::uint8_t *judged = state_.judged.data(), *prior = state_.prior.data(), *seed = state_.seed.data(),
                 *dynamic = state_.dynamic.data();
    for (std::size_t i = 0; i < size(); ++i) {
      const auto rejected = static_cast<std::uint8_t>(vote[i] == Vote::Dynamic);
      prior[i] |= suspect[i];
      dynamic[i] |= rejected;
      judged[i] &= rejected ^ 1;
      seed[i] &= (rejected | suspect[i]) ^ 1;
    }
  }
  /// Restricts judgement to the prior suspects, or to the other features.
  void keep_side(bool priors) {
    const std::uint8_t side = priors ? 1 : 0;
    for (std::size_t i = 0; i < size(); ++i)
      state_.judged[i] &= static_cast<std::uint8_t>(state_.prior[i] == side);
  }

  /// Restores the state of the next stages on destruction.
  class Scope {
   public:
    explicit Scope(Context& context) : context_(context), saved_(context.state_) {}
    ~Scope() { std::swap(context_.state_, saved_); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Context& context_;
    State saved_;
  };

  // ---- for the pipeline: start and end of a frame
  void set_history(int frames) { history_.set_capacity(frames); }
  /// Set if a stage reads boxes or masks. The motion trail for late ones is then recorded.
  void set_semantics(bool used) { semantics_used_ = used; }

  void begin(const FrameView& frame, CallPoint call_point) {
    if (std::exchange(last_begun_id_, frame.id) != frame.id)
      steps_shared_ = std::exchange(last_asked_for_, false);
    frame_ = frame;
    call_point_ = call_point;
    correspondence_ms_ = 0;
    note_.clear();
    cleaner_.clean(frame_);
    inputs_ = inputs_of(frame_);
    const std::size_t n = frame_.size();
    state_.judged.assign(n, 1);
    state_.prior.assign(n, 0);
    state_.seed.assign(n, 1);
    state_.dynamic.assign(n, 0);
    pixels_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      pixels_[i] = frame_.keypoints[i].pt;
      if (std::isnan(pixels_[i].x)) state_.judged[i] = state_.seed[i] = 0;
    }
    undistorted_ready_ = depths_ready_ = points_ready_ = thin_depth_ready_ = false;
    for (Match& match : matches_) match.valid = false;
    for (MatchedFeatures& matched : matched_features_) matched.valid = false;
    for (auto& slot : two_views_) slot.valid = false;
    for (auto& slot : rigid_motions_) slot.valid = false;
    keep(history_.current(frame.id));
  }

  void finish(bool keyframe) {
    if (semantics_used_ && may_come_late()) record_step();
    if (keyframe) history_.mark_keyframe();
    frame_ = FrameView();  // the host's memory is not read after the call
  }

  void reset() {
    history_.clear();
    late_.reset();
    steps_shared_ = last_asked_for_ = true;
  }

  void update_pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance) {
    StoredFrame* stored = history_.find(frame_id);
    if (stored != nullptr && is_rigid(T_world_camera)) {
      stored->T_world_camera = T_world_camera;
      stored->pose_provenance = provenance;
    }
  }

  double correspondence_ms() const { return correspondence_ms_; }
  /// Inputs that were present but unusable, e.g. "depth_m cannot be used: wrong size or type".
  const std::vector<std::string>& input_notes() const { return cleaner_.notes(); }

 private:
  template <class Model>
  struct Fitted {
    bool valid = false;
    const Match* match = nullptr;
    std::vector<int> seeds;
    Model model;
  };
  // A list keeps references to its entries valid while it grows.
  template <class T>
  static T& next_slot(std::list<T>& slots) {
    for (T& slot : slots)
      if (!slot.valid) {
        slot.valid = true;
        return slot;
      }
    slots.emplace_back();
    slots.back().valid = true;
    return slots.back();
  }
  /// The model of these seeds, from the cache or newly fitted.
  template <class Model, class Fit>
  const Model& fitted(std::list<Fitted<Model>>& known, const Match& match, const std::vector<int>& seeds,
                      const Fit& fit) {
    for (const Fitted<Model>& slot : known)
      if (slot.valid && slot.match == &match && slot.seeds == seeds) return slot.model;
    Fitted<Model>& slot = next_slot(known);
    slot.match = &match;
    slot.seeds = seeds;
    slot.model = fit();
    return slot.model;
  }

  const StoredFrame* resolve(const Reference& reference) const {
    if (uses_host_matches()) return history_.find(frame_.matches->reference_frame_id);
    return reference.keyframe ? history_.keyframe() : history_.before(reference.gap_frames);
  }
  bool uses_host_matches() const {
    if (!frame_.matches) return false;
    return params_.source == CorrespondenceSource::Auto || params_.source == CorrespondenceSource::Host;
  }
  bool uses_flow() const {
    return params_.source == CorrespondenceSource::Flow ||
           (params_.source == CorrespondenceSource::Auto && !frame_.matches && !frame_.grey.empty());
  }

  /// Records the motion since the last frame for late results, once per frame.
  void record_step() {
    late_seen_ = late_seen_ || is_late();
    if (late_.trail().find(frame_.id) != nullptr) return;
    const Match& last = step_match();
    cv::Size image_px = frame_.grey.size();
    if (image_px.empty()) image_px = frame_.depth.size();
    if (image_px.empty() && frame_.camera) image_px = {frame_.camera->width_px, frame_.camera->height_px};
    late_.trail().add(frame_.id, last, pixels_, depths_m(), thin_depth(), image_px);
  }
  /// This frame's subsampled depth image. The trail takes over its memory.
  cv::Mat& thin_depth() {
    if (!thin_depth_ready_) MotionTrail::thin_depth(frame_.depth, frame_.depth_unit_m, thin_depth_m_);
    thin_depth_ready_ = true;
    return thin_depth_m_;
  }
  bool is_late() const {
    const auto older = [this](std::int64_t id) { return id >= 0 && id != frame_.id; };
    return (frame_.detections && older(frame_.detections->frame_id)) ||
           (frame_.mask && older(frame_.mask->frame_id));
  }
  /// False while results arrive on time: the trail is not needed.
  /// Before the first late result, the trail must not cause extra flow.
  bool may_come_late() const {
    if (is_late()) return true;
    if (frame_.detections || frame_.mask) return false;
    const StoredFrame* last = resolve(Reference());
    return late_seen_ || last == nullptr || is_matched(last);
  }
  bool is_matched(const StoredFrame* stored) const {
    return std::any_of(matches_.begin(), matches_.end(),
                       [stored](const Match& match) { return match.valid && match.reference == stored; });
  }

  /// The match to the last frame that the trail is built from.
  /// It is the match of the stages if they compute one.
  /// Otherwise it is a sparse one at a sixth of the cost.
  const Match& step_match() {
    const StoredFrame* last = resolve(Reference());
    if (steps_shared_ || !uses_flow() || is_matched(last)) return match_stored(last);
    sparse_px_ = pixels_;
    for (cv::Point2f& px : sparse_px_)
      if (!in_sparse_cell(px)) px.x = px.y = std::numeric_limits<float>::quiet_NaN();
    fill_match(last, step_, [&](Correspondences& out) {
      step_flow_.track(history_.find(frame_.id)->pyramid, last->pyramid, sparse_px_, {}, out);
    });
    return step_;
  }
  /// True in one of four cells of 8 x 8 pixels.
  /// Selecting by position makes the result independent of the features' order.
  static bool in_sparse_cell(const cv::Point2f& px) {
    return std::fmod(std::floor(px.x / 8) + 2 * std::floor(px.y / 8), 4.0F) == 0;
  }
  static FlowParams checked_once(FlowParams params) {
    if (params.check == FlowCheck::ForwardBackward) params.check = FlowCheck::Residual;
    return params;
  }

  const Match& match_stored(const StoredFrame* stored) {
    for (const Match& known : matches_)
      if (known.valid && known.reference == stored) return known;
    depths_m();  // before the flow evicts the depth image from the cache
    Match& match = next_slot(matches_);
    fill_match(stored, match, [&](Correspondences& out) { correspond(*stored, out); });
    return match;
  }

  // The host's matches refer to one frame.
  // Late boxes need another frame, which uses flow or descriptors instead.
  void correspond(const StoredFrame& stored, Correspondences& out) {
    if (uses_host_matches() && frame_.matches->reference_frame_id == stored.id)
      host_matches(stored, out);
    else if (uses_flow())
      flow_.track(history_.find(frame_.id)->pyramid, stored.pyramid, pixels_, {}, out);
    else
      descriptors_.match({frame_.keypoints, frame_.descriptors}, {stored.keypoints, stored.descriptors}, {},
                         out);
  }

  void host_matches(const StoredFrame& stored, Correspondences& out) {
    const std::size_t nowhere = correspondences_from_host(*frame_.matches, stored.keypoints, size(), out);
    if (nowhere > 0)
      note(std::to_string(nowhere) + " matches lead to features that frame " + std::to_string(stored.id) +
           " does not have");
    for (std::size_t i = 0; i < size(); ++i)
      if (std::isnan(pixels_[i].x)) out.drop(i);
  }

  template <class Correspond>
  void fill_match(const StoredFrame* stored, Match& match, const Correspond& correspond) {
    const auto start = std::chrono::steady_clock::now();
    match.reference = stored;
    match.correspondences.reset(size());
    if (stored != nullptr) correspond(match.correspondences);
    fill_reference_geometry(match);
    correspondence_ms_ +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }

  void fill_reference_geometry(Match& match) const {
    const auto& px = match.correspondences.reference_px;
    const Camera camera = match.reference != nullptr ? match.reference->camera.value_or(Camera()) : Camera();
    match.reference_undistorted_px.resize(size());
    undistort_points(camera, px, match.reference_undistorted_px);
    match.reference_depth_m.assign(size(), DepthSampler::kNone);
    if (match.reference != nullptr) {
      const StoredFrame& stored = *match.reference;
      const DepthSampler image(stored.depth, stored.depth_unit_m, params_.max_depth_edge);
      image.at_all(px, [&](std::size_t i, float in_image) {
        if (match.correspondences.found[i] == 0) return;
        const auto index = static_cast<std::size_t>(match.correspondences.reference_index[i]);
        const bool by_feature =
            match.correspondences.reference_index[i] >= 0 && index < stored.depth_m.size();
        match.reference_depth_m[i] = usable(by_feature ? stored.depth_m[index] : in_image);
      });
    }
    match.reference_points_m.resize(size());
    back_project(camera, match.reference_undistorted_px, match.reference_depth_m, match.reference_points_m);
  }

  float usable(float depth_m) const {
    return valid_depth(depth_m) && static_cast<double>(depth_m) <= params_.max_depth_m ? depth_m
                                                                                       : DepthSampler::kNone;
  }

  void fill_undistorted() {
    if (!frame_.keypoints_undistorted.empty()) {
      undistorted_.resize(size());
      for (std::size_t i = 0; i < size(); ++i) undistorted_[i] = frame_.keypoints_undistorted[i].pt;
    } else {
      undistorted_.resize(size());
      undistort_points(frame_.camera.value_or(Camera()), pixels_, undistorted_);
    }
    undistorted_ready_ = true;
  }

  /// Depths of the host, except on silhouettes of the depth image.
  void fill_depths() {
    depths_m_.assign(size(), DepthSampler::kNone);
    const DepthSampler image(frame_.depth, frame_.depth_unit_m, params_.max_depth_edge);
    image.at_all(pixels_, [&](std::size_t i, float in_image) {
      const float seen = frame_.depth.empty() ? 0.0F : in_image;
      const float given = frame_.depth_m.empty() ? seen : frame_.depth_m[i];
      depths_m_[i] = std::isnan(seen) ? DepthSampler::kNone : usable(given);
    });
    depths_ready_ = true;
  }

  /// Makes deep copies, because hosts reuse buffers. The pyramid is the copy of the grey image.
  void keep(StoredFrame& stored) {
    const bool seen_before = !stored.pyramid.empty();
    stored.timestamp_s = frame_.timestamp_s;
    stored.keypoints.assign(frame_.keypoints.begin(), frame_.keypoints.end());
    stored.depth_m.assign(frame_.depth_m.begin(), frame_.depth_m.end());
    stored.camera = frame_.camera;
    if (frame_.pose_provenance != PoseProvenance::None) {
      stored.T_world_camera = frame_.T_world_camera;
      stored.pose_provenance = frame_.pose_provenance;
    }
    frame_.descriptors.copyTo(stored.descriptors);
    if (uses_flow() && !seen_before) {
      const auto start = std::chrono::steady_clock::now();
      flow_.build(frame_.grey, stored.pyramid);
      correspondence_ms_ +=
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    }
    if (!seen_before) {
      keep_depth(stored.depth);
      stored.depth_unit_m = frame_.depth_unit_m;
      if (semantics_used_) thin_depth();  // before the flow evicts the depth image from the cache
    }
  }

  /// Writes into the slot's image only if nothing else refers to it.
  /// The host may still hold an image that it handed over.
  void keep_depth(cv::Mat& stored) {
    if (frame_.depth_handed_over) {
      stored = frame_.depth;
      return;
    }
    if (!has_sole_owner(stored)) stored.release();
    frame_.depth.copyTo(stored);
  }

  ContextParams params_;
  History history_;
  FlowTracker flow_, step_flow_;
  DescriptorMatcher descriptors_;
  TwoViewEstimator two_view_;
  RigidMotionEstimator rigid_motion_;

  FrameCleaner cleaner_;
  FrameView frame_;
  CallPoint call_point_ = CallPoint::BeforePose;
  Input inputs_ = Input::None;
  State state_;
  std::string note_;
  bool collects_suspicions_ = false;
  std::vector<std::uint64_t> suspected_by_;
  double correspondence_ms_ = 0;
  LateSemantics late_;
  std::vector<Detection> carried_;
  bool semantics_used_ = false, late_seen_ = false;
  cv::Mat thin_depth_m_;
  Match step_;
  std::vector<cv::Point2f> sparse_px_;
  std::int64_t last_begun_id_ = -1;
  bool last_asked_for_ = true, steps_shared_ = true;  ///< true if stages match with the last frame

  std::vector<cv::Point2f> pixels_, undistorted_;
  std::vector<float> depths_m_;
  std::vector<cv::Point3f> points_m_;
  bool undistorted_ready_ = false, depths_ready_ = false, points_ready_ = false, thin_depth_ready_ = false;
  std::list<Match> matches_;
  std::list<MatchedFeatures> matched_features_;
  std::list<Fitted<TwoViewModel>> two_views_;
  std::list<Fitted<RigidMotion>> rigid_motions_;
};

}  // namespace dynfilter
