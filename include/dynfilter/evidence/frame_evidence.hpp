// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/evidence/earlier_votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <memory>
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
  ~FrameEvidence() override;
  FrameEvidence(const FrameEvidence&) = delete;
  FrameEvidence& operator=(const FrameEvidence&) = delete;

  /// How many earlier frames to keep.
  void set_history(int frames);
  /// Set if a stage reads boxes or masks. The motion that late ones are carried along is then recorded.
  void set_semantics(bool used);

  void begin(const FrameView& frame, CallPoint call_point);
  /// The frame's memory is not read after this.
  void end(bool keyframe);
  /// Forgets all earlier frames.
  void reset();
  /// Does what needs no features of the next frame, see Pipeline::prepare().
  void prepare(const cv::Mat& grey, double timestamp_s);
  bool prepared_in_vain() const;  ///< for another image or stamp
  void forget_poses();            ///< of all earlier frames
  /// Sets the pose of an earlier frame. Ignored if it is no longer kept, or not rigid.
  void update_pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance);

  /// For combinators.
  EarlierVotes& earlier_votes() { return earlier_votes_; }
  /// Milliseconds since some moment. Null: correspondence_ms() stays 0.
  void set_clock(double (*clock_ms)());
  /// Time for matches of this frame [ms]; 0 without a clock.
  double correspondence_ms() const;
  /// Inputs that were present but unusable, e.g. "depth_m cannot be used: wrong size or type".
  const std::vector<std::string>& input_notes() const;
  /// What was odd about the host's matches. Empty: nothing.
  std::string take_match_note();
  /// Of the match with the last frame. Null: nobody asked for that match.
  const std::vector<MatchSpread>* spread() const;

  const FrameView& frame() const override;
  CallPoint call_point() const override { return call_point_; }
  Input inputs() const override;
  std::size_t size() const override;
  const std::vector<cv::Point2f>& pixels() const override;
  const std::vector<cv::Point2f>& undistorted_pixels() const override;
  const std::vector<float>& depths_m() const override;
  const std::vector<cv::Point3f>& points_m() const override;

  using Evidence::called_dynamic;  ///< of one feature, too
  using Evidence::judged;          ///< of one feature, too
  using Evidence::prior;           ///< of one feature, too
  using Evidence::seed;            ///< of one feature, too
  Span<const std::uint8_t> judged() const override { return earlier_votes_.judged(); }
  Span<const std::uint8_t> prior() const override { return earlier_votes_.prior(); }
  Span<const std::uint8_t> seed() const override { return earlier_votes_.seed(); }
  Span<const std::uint8_t> called_dynamic() const override { return earlier_votes_.called_dynamic(); }

  const Match& match(const Reference& reference) const override;
  const Match& second_look(const Match& match, const Pose& T_current_reference,
                           Span<const std::uint8_t> doubted) const override;
  const Match& match_with(std::int64_t frame_id) const override;
  const MatchedFeatures& matched_features(
      const Match& match, double max_offset_px = MatchedFeatures::kMaxOffsetPx) const override;
  const FeatureTracks& tracks(const TrackOptions& options) const override;
  const PastFrame* kept_frame(std::int64_t frame_id) const override;

  void collect_seeds(const Match& match, bool all, std::vector<int>& seeds) const override;
  const TwoViewModel& two_view(const Match& match, const std::vector<int>& seeds) const override;
  const RigidMotion& rigid_motion(const Match& match, const std::vector<int>& seeds) const override;
  std::optional<Pose> host_motion(const Match& match) const override;
  std::optional<MotionPrior> motion_prior(const Match& match) const override;

  const std::vector<Detection>* carried_boxes(int max_age_frames) const override;
  const cv::Mat* carried_labels() const override;

 private:
  struct Owners;

  CallPoint call_point_ = CallPoint::BeforePose;
  EarlierVotes earlier_votes_;
  std::unique_ptr<Owners> owners_;  ///< a caller does not compile them
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/frame_evidence-inl.hpp>
#endif
