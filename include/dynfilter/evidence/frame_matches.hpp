// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <dynfilter/correspondence/flow.hpp>
#include <dynfilter/correspondence/flow_params.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/correspondence_params.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/history.hpp>
#include <dynfilter/evidence/matched_features.hpp>
#include <list>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Where the current features were in earlier frames, and these frames themselves.
/// Every match is computed on first use, once per frame.
class FrameMatches {
 public:
  FrameMatches(const CorrespondenceParams& params, CurrentFrame& current)
      : params_(params),
        current_(current),
        flow_(params.flow, params.threads),
        step_flow_(checked_once(params.flow), params.threads),
        descriptors_(params.descriptors) {}

  const History& history() const { return history_; }
  History& history() { return history_; }

  /// Stores the frame that begins. False if it is there already, from an earlier call point.
  bool begin();
  void reset();

  const Match& match(const Reference& reference);
  const Match& match_with(std::int64_t frame_id) { return match_stored(history_.find(frame_id)); }

  const MatchedFeatures& matched_features(const Match& match, double max_offset_px);

  /// The match with the last frame for late results: that of the stages if they compute one, otherwise a
  /// sparse one at a sixth of the cost.
  const Match& step_match();
  /// A match with the last frame costs nothing more, because there is one, or no such frame.
  bool has_step() const;

  double correspondence_ms() const { return correspondence_ms_; }
  /// What was odd about the host's matches. Empty: nothing.
  std::string take_note() { return std::exchange(note_, {}); }

 private:
  static FlowParams checked_once(FlowParams params);
  /// True in one of four cells of 8 x 8 pixels.
  /// Selecting by position makes the result independent of the features' order.
  static bool in_sparse_cell(const cv::Point2f& px) {
    return std::fmod(std::floor(px.x / 8) + 2 * std::floor(px.y / 8), 4.0F) == 0;
  }

  const StoredFrame* resolve(const Reference& reference) const;
  bool uses_host_matches() const;
  bool uses_flow() const;
  bool is_matched(const StoredFrame* stored) const;

  const Match& match_stored(const StoredFrame* stored);

  // The host's matches refer to one frame.
  // Late boxes need another frame, which uses flow or descriptors instead.
  void correspond(const StoredFrame& stored, Correspondences& out);

  void descriptor_matches(const StoredFrame& stored, Correspondences& out);
  void host_matches(const StoredFrame& stored, Correspondences& out);

  template <class Correspond>
  void fill_match(const StoredFrame* stored, Match& match, const Correspond& correspond);
  void add_time_since(std::chrono::steady_clock::time_point start);

  void fill_reference_geometry(Match& match);
  void fill_stereo_depths(Match& match);

  /// Makes deep copies, because hosts reuse buffers. The pyramid is the copy of the grey image.
  bool keep(StoredFrame& stored);

  /// Writes into the slot's image only if nothing else refers to it.
  /// The host may still hold an image that it handed over.
  void keep_depth(cv::Mat& stored) const;

  const CorrespondenceParams& params_;
  CurrentFrame& current_;
  History history_;
  FlowTracker flow_, step_flow_;
  DescriptorMatcher descriptors_;
  std::list<Match> matches_;
  std::list<MatchedFeatures> matched_features_;
  MatchedFeatures reference_features_;  ///< scratch
  Match step_;
  std::vector<cv::Point2f> sparse_px_;
  std::string note_;
  double correspondence_ms_ = 0;
  std::int64_t last_begun_id_ = -1;
  bool last_asked_for_ = true, steps_shared_ = true;  ///< true if stages match with the last frame
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/frame_matches-inl.hpp>
#endif
