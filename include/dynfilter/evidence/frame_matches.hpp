// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <dynfilter/correspondence/flow.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/correspondence/patch_residual.hpp>
#include <dynfilter/correspondence/row_search.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/history.hpp>
#include <dynfilter/evidence/matched_features.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <limits>
#include <list>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Where the current features were in earlier frames, and these frames themselves.
/// Every match is computed on first use, once per frame.
class FrameMatches {
 public:
  /// Refers to `current`, which must outlive it.
  FrameMatches(const CorrespondenceParams& params, CurrentFrame& current)
      : params_(params),
        current_(current),
        flow_(params.flow, params.threads),
        step_flow_(checked_once(params.flow), params.threads),
        descriptors_(params.descriptors),
        far_descriptors_(searching_far(params.descriptors)),
        unlike_(params.flow.window_px) {}

  const History& history() const { return history_; }  ///< the earlier frames that are kept
  History& history() { return history_; }

  /// Stores the frame that begins. False if it is there already, from an earlier call point.
  bool begin() {
    const std::int64_t id = current_.frame().id;
    if (std::exchange(last_begun_id_, id) != id) steps_shared_ = std::exchange(last_asked_for_, false);
    correspondence_ms_ = 0;
    prepared_in_vain_ = false;
    note_.clear();
    detail::free_slots(matches_);
    detail::free_slots(second_looks_);
    detail::free_slots(matched_features_);
    return keep(history_.current(id));
  }
  /// The pyramid of the next frame, and the flow that needs no features. See Pipeline::prepare().
  void prepare(const cv::Mat& grey, double timestamp_s) {
    prepared_s_ = timestamp_s;
    if (params_.source != CorrespondenceSource::Auto && params_.source != CorrespondenceSource::Flow) return;
    flow_.forget_prepared();
    flow_.build(grey, prepared_);
    if (last_asked_for_ && history_.newest() != nullptr) flow_.prepare(prepared_, history_.newest()->pyramid);
  }
  bool prepared_in_vain() const { return prepared_in_vain_; }  ///< another image or stamp than the frame's
  void reset() {
    history_.clear();
    prepared_.clear();
    steps_shared_ = last_asked_for_ = true;
  }
  /// See Evidence::match().
  const Match& match(const Reference& reference) {
    const StoredFrame* stored = resolve(reference);
    last_asked_for_ = last_asked_for_ || stored == resolve(Reference());
    return match_stored(stored);
  }
  /// See Evidence::match_with().
  const Match& match_with(std::int64_t frame_id) { return match_stored(history_.find(frame_id)); }
  /// See Evidence::second_look().
  const Match& second_look(const Match& match, const Pose& T_current_reference,
                           Span<const std::uint8_t> doubted) {
    if (!match.reference || doubted.size() != current_.size() || !current_.frame().camera) return match;
    const StoredFrame& then = stored(match);
    const cv::Mat now = history_.find(current_.frame().id)->pyramid.image(), past = then.pyramid.image();
    if (now.empty() || past.empty()) return match;
    find_places(T_current_reference, true,
                [&](std::size_t i) { return doubted[i] != 0 && current_.depths_m()[i] > 0; });
    track_from_places(then);
    Match& second = detail::next_slot(second_looks_);
    second = match;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (far_.found[i] != 0 && !is_static_match(match, i, now, past)) far_.drop(i);
      if (far_.found[i] != 0) adopt(i, second.correspondences);
    }
    fill_reference_geometry(second, far_.found);
    return second;
  }
  /// See Evidence::matched_features().
  const MatchedFeatures& matched_features(const Match& match, double max_offset_px) {
    for (const MatchedFeatures& known : matched_features_)
      if (known.valid && known.is_of(match, max_offset_px)) return known;
    MatchedFeatures& matched = detail::next_slot(matched_features_);
    matched.assign(current_.frame(), match, max_offset_px);
    return matched;
  }
  /// The match with the last frame for late results. It is that of the stages if they compute one, otherwise
  /// a sparse one at a sixth of the cost.
  const Match& step_match() {
    const StoredFrame* last = resolve(Reference());
    if (steps_shared_ || !uses_flow() || is_matched(last)) return match_stored(last);
    sparse_px_ = current_.pixels();
    for (cv::Point2f& px : sparse_px_)
      if (!in_sparse_cell(px)) px.x = px.y = std::numeric_limits<float>::quiet_NaN();
    fill_match(last, step_, [&](Correspondences& out) {
      step_flow_.track(history_.find(current_.frame().id)->pyramid, last->pyramid, sparse_px_, {}, out);
    });
    return step_;
  }
  /// A match with the last frame costs nothing more, because there is one, or no such frame.
  bool has_step() const {
    const StoredFrame* last = resolve(Reference());
    return last == nullptr || is_matched(last);
  }
  /// Of the match with the last frame. Null: nobody asked for that match.
  const std::vector<MatchSpread>* spread() const {
    const StoredFrame* last = resolve(Reference());
    for (const Match& match : matches_)
      if (match.valid && last != nullptr && match.reference == last) return &match.correspondences.spread;
    return nullptr;
  }
  /// The frame's prior on the camera's motion, if it begins at `reference`. Null: there is none.
  const MotionPrior* motion_prior(const PastFrame* reference) const {
    const std::optional<MotionPrior>& prior = current_.frame().motion_prior;
    if (!prior || reference == nullptr) return nullptr;
    const std::int64_t from = prior->reference_frame_id;
    const bool same = from >= 0 ? from == reference->id : reference == history_.before(1);
    return same ? &*prior : nullptr;
  }
  /// Time for matches of this frame [ms]; 0 without a clock.
  double correspondence_ms() const { return correspondence_ms_; }
  void set_clock(double (*clock_ms)()) { now_ms_ = clock_ms; }  ///< [ms]; without one, no time is measured
  /// What was odd about the host's matches. Empty: nothing.
  std::string take_note() { return std::exchange(note_, {}); }

 private:
  static FlowParams checked_once(FlowParams params) {
    if (params.check == FlowCheck::ForwardBackward) params.check = FlowCheck::Residual;
    return params;
  }
  static constexpr int kNearWindows = 2;  ///< flow finds without help what is as near as two of its windows
  static constexpr double kMostRecession = 2;  ///< of a distance from frame to frame
  static constexpr float kStaticReach_px = 2;  ///< of a match from the place of a static one
  static constexpr double kFar_px = 120;       ///< a car at 8 m that comes nearer at 20 m/s, at 10 Hz
  static constexpr double kLongStep_s = 0.04;  ///< in which a walker at 1.5 m jumps those two windows
  static DescriptorMatchParams searching_far(DescriptorMatchParams params) {
    params.search_radius_px = std::max(params.search_radius_px, kFar_px);
    return params;
  }
  /// True in one of four cells of 8 x 8 pixels.
  /// Selecting by position makes the result independent of the features' order.
  static bool in_sparse_cell(const cv::Point2f& px) {
    return std::fmod(std::floor(px.x / 8) + 2 * std::floor(px.y / 8), 4.0F) == 0;
  }

  /// The frame that a match refers to: all of them are in history_.
  static const StoredFrame& stored(const Match& m) { return static_cast<const StoredFrame&>(*m.reference); }
  const StoredFrame* resolve(const Reference& reference) const {
    if (uses_host_matches()) return history_.find(current_.frame().matches->reference_frame_id);
    return reference.keyframe ? history_.keyframe() : history_.before(reference.gap_frames);
  }
  bool uses_host_matches() const {
    if (!current_.frame().matches) return false;
    return params_.source == CorrespondenceSource::Auto || params_.source == CorrespondenceSource::Host;
  }
  bool uses_flow() const {
    const FrameView& frame = current_.frame();
    return params_.source == CorrespondenceSource::Flow ||
           (params_.source == CorrespondenceSource::Auto && !frame.matches && !frame.grey.empty());
  }
  bool is_matched(const StoredFrame* stored) const {
    return std::any_of(matches_.begin(), matches_.end(),
                       [stored](const Match& match) { return match.valid && match.reference == stored; });
  }
  const Match& match_stored(const StoredFrame* stored) {
    for (const Match& known : matches_)
      if (known.valid && known.reference == stored) return known;
    current_.depths_m();  // before the flow evicts the depth image from the cache
    Match& match = detail::next_slot(matches_);
    fill_match(stored, match, [&](Correspondences& out) { correspond(*stored, out); });
    return match;
  }

  // The host's matches refer to one frame.
  // Late boxes need another frame, which uses flow or descriptors instead.
  void correspond(const StoredFrame& stored, Correspondences& out) {
    const FrameView& frame = current_.frame();
    if (uses_host_matches() && frame.matches->reference_frame_id == stored.id)
      host_matches(stored, out);
    else if (uses_flow()) {
      track(stored, current_.pixels(), starts(stored), out);
      find_by_prior(stored, out);
    } else
      descriptor_matches(stored, out);
  }

  /// Where descriptors are found: flow does not search as far as features jump in a long step. Empty after a
  /// short one, and with a depth camera: indoors too much looks alike.
  Span<const cv::Point2f> starts(const StoredFrame& stored) {
    const FrameView& frame = current_.frame();
    const bool depth_camera = !is_stereo(frame) && !(frame.depth.empty() && frame.depth_m.empty());
    if (depth_camera || !(frame.timestamp_s - stored.timestamp_s > kLongStep_s)) return {};
    far_descriptors_.match({frame.keypoints, frame.descriptors}, {stored.keypoints, stored.descriptors}, {},
                           far_);
    return far_.reference_px;  // NaN where nothing was found
  }
  /// Flow of features without a match, from where the prior on the camera's motion expects them.
  void find_by_prior(const StoredFrame& stored, Correspondences& out) {
    const MotionPrior* prior = motion_prior(&stored);
    if (prior == nullptr || !current_.frame().camera) return;
    find_places(prior->T_current_reference, prior->has_translation,
                [&](std::size_t i) { return out.found[i] == 0; });
    const double near_px = kNearWindows * params_.flow.window_px;
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (!(cv::norm(places_[i] - current_.pixels()[i]) > near_px)) places_[i].x = std::nanf("");
    track_from_places(stored);
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (far_.found[i] != 0) adopt(i, out);
  }
  void adopt(std::size_t i, Correspondences& out) const {
    out.set(i, far_.reference_px[i]);
    out.spread[i] = far_.spread[i];
  }
  /// Into places_: where features that are `wanted(i)` were if they rest, as motion and depth tell, else NaN.
  template <class Wanted>
  void find_places(const Pose& T_current_reference, bool has_translation, const Wanted& wanted) {
    const Camera& camera = *current_.frame().camera;
    const Pose T_reference_current = inverse(T_current_reference);
    const Eigen::Matrix3d R = T_reference_current.R();
    const std::vector<cv::Point2f>& undistorted = current_.undistorted_pixels();
    const std::vector<float>& depth_m = current_.depths_m();
    places_.assign(current_.size(), {std::nanf(""), std::nanf("")});
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!wanted(i)) continue;
      const cv::Point2f& px = undistorted[i];
      Eigen::Vector3d p =
          R * Eigen::Vector3d((px.x - camera.cx_px) / camera.fx_px, (px.y - camera.cy_px) / camera.fy_px, 1);
      if (has_translation && depth_m[i] > 0) p += T_reference_current.t() / depth_m[i];
      places_[i] = current_.pixels()[i] + project(camera, to_point(p)) - px;
    }
  }
  /// Into far_: flow of the features that have a place to start from.
  void track_from_places(const StoredFrame& stored) {
    sparse_px_ = current_.pixels();
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (std::isnan(places_[i].x)) sparse_px_[i] = places_[i];
    track(stored, sparse_px_, places_, far_);
  }
  void track(const StoredFrame& stored, Span<const cv::Point2f> px, Span<const cv::Point2f> guess,
             Correspondences& out) {
    const ImagePyramid& now = history_.find(current_.frame().id)->pyramid;
    flow_.prepare(now, stored.pyramid);
    flow_.track(now, stored.pyramid, px, guess, out);
  }
  /// What is in far_ is where a static feature is, and looks no less like it than what `match` has.
  bool is_static_match(const Match& match, std::size_t i, const cv::Mat& now, const cv::Mat& then) {
    const cv::Point2f &px = current_.pixels()[i], &found = far_.reference_px[i], off = found - places_[i];
    if (!(off.dot(off) <= kStaticReach_px * kStaticReach_px)) return false;
    return !match.found(i) ||
           unlike_(now, px, then, found) <= unlike_(now, px, then, match.correspondences.reference_px[i]);
  }
  void descriptor_matches(const StoredFrame& stored, Correspondences& out) {
    const FrameView& frame = current_.frame();
    descriptors_.match({frame.keypoints, frame.descriptors}, {stored.keypoints, stored.descriptors}, {}, out);
    if (descriptors_.crowded() > 0)
      note_ = std::to_string(descriptors_.crowded()) + " features have more than " +
              std::to_string(limits::kMaxWindow) + " candidates: not matched";
  }
  void host_matches(const StoredFrame& stored, Correspondences& out) {
    const std::size_t nowhere =
        correspondences_from_host(*current_.frame().matches, stored.keypoints, current_.size(), out);
    if (nowhere > 0)
      note_ = std::to_string(nowhere) + " matches lead to features that frame " + std::to_string(stored.id) +
              " does not have";
    for (std::size_t i = 0; i < current_.size(); ++i)
      if (std::isnan(current_.pixels()[i].x)) out.drop(i);
  }

  template <class Correspond>
  void fill_match(const StoredFrame* stored, Match& match, const Correspond& correspond) {
    const double start_ms = now_ms();
    match.reference = stored;
    match.correspondences.reset(current_.size());
    if (stored != nullptr) correspond(match.correspondences);
    match.reference_depth_m.assign(current_.size(), DepthSampler::kNone);
    fill_reference_geometry(match, match.correspondences.found);
    correspondence_ms_ += now_ms() - start_ms;
  }
  double now_ms() const { return now_ms_ != nullptr ? now_ms_() : 0; }

  /// Of the features in `changed`. The depths of the others stay.
  void fill_reference_geometry(Match& match, const std::vector<std::uint8_t>& changed) {
    const std::size_t n = current_.size();
    const auto& px = match.correspondences.reference_px;
    const Camera camera = match.reference != nullptr ? match.reference->camera.value_or(Camera()) : Camera();
    match.reference_undistorted_px.resize(n);
    undistort_points(camera, px, match.reference_undistorted_px);
    if (match.reference != nullptr && match.reference->stereo) {
      fill_stereo_depths(match, changed);
    } else if (match.reference != nullptr) {
      const PastFrame& stored = *match.reference;
      const DepthSampler image(stored.depth, stored.depth_unit_m, DepthSampler::kMaxDepthEdge);
      image.at_all(px, [&](std::size_t i, float in_image) {
        if (changed[i] == 0) return;
        const auto index = static_cast<std::size_t>(match.correspondences.reference_index[i]);
        const bool by_feature =
            match.correspondences.reference_index[i] >= 0 && index < stored.depth_m.size();
        match.reference_depth_m[i] =
            depth_within(by_feature ? stored.depth_m[index] : in_image, params_.max_depth_m);
      });
    }
    fill_slopes(match);
    match.reference_points_m.resize(n);
    back_project(camera, match.reference_undistorted_px, match.reference_depth_m, match.reference_points_m);
  }
  /// Of the reference frame's own features, else found in its right image.
  void fill_stereo_depths(Match& match, const std::vector<std::uint8_t>& changed) {
    const StoredFrame& then = stored(match);
    const cv::Mat left = then.right_grey.empty() ? cv::Mat() : then.pyramid.image();
    const RowSearch search(left, left.empty() ? left : then.right_grey, then.left_brighter);
    reference_features_.find(match, MatchedFeatures::kMaxOffsetPx);
    for (std::size_t i = 0; i < current_.size(); ++i) {
      if (changed[i] == 0) continue;
      const auto index = static_cast<std::size_t>(reference_features_.index(i));
      float& depth_m = match.reference_depth_m[i];
      if (reference_features_.index(i) >= 0 && index < then.depth_m.size()) {
        depth_m = then.depth_m[index];
      } else if (!left.empty()) {
        const double bf_px_m = then.camera->baseline_fx_px_m, now_px = bf_px_m / current_.depths_m()[i];
        const double most_px = std::min<double>(RowSearch::kMost_px, kMostRecession * now_px);
        const float right_px = search.column(match.correspondences.reference_px[i], cvCeil(most_px));
        depth_m = stereo_depth_m(match.reference_undistorted_px[i].x, right_px, bf_px_m);
      }
    }
  }
  /// The slope of the surface along the edges on which matches slide, in this frame's depth image.
  void fill_slopes(Match& match) const {
    constexpr float kReach_px = 6, kAnyEdge = 1e9F;
    const FrameView& frame = current_.frame();
    if (frame.depth.empty()) return;
    const DepthSampler depth(frame.depth, frame.depth_unit_m, static_cast<double>(kAnyEdge));
    for (std::size_t i = 0; i < current_.size(); ++i) {
      MatchSpread& spread = match.correspondences.spread[i];
      if (!match.found(i) || !spread.slides()) continue;
      const cv::Point2f& px = current_.pixels()[i];
      const float rise_m = depth.at(px + kReach_px * spread.edge) - depth.at(px - kReach_px * spread.edge);
      if (std::isfinite(rise_m)) spread.depth_per_px = rise_m / (2 * kReach_px);
    }
  }

  /// Makes deep copies, because hosts reuse buffers. The pyramid is the copy of the grey image.
  bool keep(StoredFrame& stored) {
    const FrameView& frame = current_.frame();
    const bool seen_before = !stored.pyramid.empty();
    stored.timestamp_s = frame.timestamp_s;
    stored.keypoints.assign(frame.keypoints.begin(), frame.keypoints.end());
    if (!seen_before) current_.forget_columns();
    if (is_stereo(frame))
      stored.depth_m = current_.depths_m(), stored.left_brighter = current_.left_brighter();
    else
      stored.depth_m.assign(frame.depth_m.begin(), frame.depth_m.end());
    stored.stereo = is_stereo(frame);
    stored.camera = frame.camera;
    if (frame.pose_provenance != PoseProvenance::None) {
      stored.T_world_camera = frame.T_world_camera;
      stored.pose_provenance = frame.pose_provenance;
    }
    frame.descriptors.copyTo(stored.descriptors);
    if (seen_before) return false;
    const double start_ms = now_ms();
    build_pyramid(stored.pyramid);
    correspondence_ms_ += now_ms() - start_ms;
    keep_depth(stored.depth);
    keep_copy(stored.stereo ? frame.right_grey : cv::Mat(), stored.right_grey);
    stored.depth_unit_m = frame.depth_unit_m;
    return true;
  }
  void build_pyramid(ImagePyramid& pyramid) {
    prepared_in_vain_ = !prepared_.empty() && !is_prepared();
    if (is_prepared()) {
      pyramid.swap(prepared_);
    } else {
      flow_.forget_prepared();
      if (uses_flow()) flow_.build(current_.frame().grey, pyramid);
    }
    prepared_.clear();
  }
  bool is_prepared() const {
    const FrameView& frame = current_.frame();
    if (!uses_flow() || prepared_.size() != frame.grey.size() || prepared_s_ != frame.timestamp_s)
      return false;
    const cv::Mat prepared = prepared_.image();
    for (int y = 0; y < prepared.rows; ++y)
      if (std::memcmp(prepared.ptr(y), frame.grey.ptr(y), static_cast<std::size_t>(prepared.cols)) != 0)
        return false;
    return true;
  }
  /// Writes into the slot's image only if nothing else refers to it.
  /// The host may still hold an image that it handed over.
  void keep_depth(cv::Mat& stored) const {
    const FrameView& frame = current_.frame();
    if (frame.depth_handed_over && frame.depth.u != nullptr)
      stored = frame.depth;
    else
      keep_copy(frame.depth, stored);
  }

  const CorrespondenceParams& params_;
  CurrentFrame& current_;
  History history_;
  FlowTracker flow_, step_flow_;
  DescriptorMatcher descriptors_, far_descriptors_;
  Correspondences far_;  ///< scratch
  std::list<Match> matches_, second_looks_;
  std::list<MatchedFeatures> matched_features_;
  MatchedFeatures reference_features_;  ///< scratch
  Match step_;
  std::vector<cv::Point2f> sparse_px_, places_;
  PatchResidual unlike_;
  std::string note_;
  ImagePyramid prepared_;
  double prepared_s_ = 0;  ///< stamp
  bool prepared_in_vain_ = false;
  double correspondence_ms_ = 0;
  double (*now_ms_)() = nullptr;
  std::int64_t last_begun_id_ = -1;
  bool last_asked_for_ = true, steps_shared_ = true;  ///< true if stages match with the last frame
};

}  // namespace dynfilter
