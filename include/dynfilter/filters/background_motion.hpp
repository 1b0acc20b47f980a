// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/judged_frame.hpp>
#include <dynfilter/filters/detail/miss_odds.hpp>
#include <dynfilter/filters/detail/neighbour_votes.hpp>
#include <dynfilter/filters/detail/track_misses.hpp>
#include <dynfilter/motion/camera_path.hpp>
#include <dynfilter/motion/free_space.hpp>
#include <dynfilter/motion/mover_forecast.hpp>
#include <dynfilter/motion/prior_evidence.hpp>
#include <dynfilter/motion/rigid_background.hpp>
#include <vector>

namespace dynfilter {

struct BackgroundMotionParams {
  /// Radius of the neighbourhood whose evidence is averaged.
  double neighbour_px = 25;
  /// Largest difference in depth within a neighbourhood.
  double neighbour_m = 0.12;

  static const FieldTable<BackgroundMotionParams>& fields();
};

/// Features that do not follow the background. The default rejector. It needs no detector.
///
/// Formula:  the background's motion is chosen among several (motion/rigid_background.hpp). Each feature's
///           residual against it in (u, v, depth) gives likelihood ratios of motion (motion/moving_odds.hpp),
///           over one frame and over its track of up to 0.2 s. They add up and fade (TrackEvidence).
///           Belief = prior + evidence + mean evidence of neighbours at a similar depth. Dynamic where it
///           outweighs the cost of a wrong rejection, if a core is near. See the card.
/// Votes:    with a confidence, the probability that the chosen motion is the background's. Below 1/3 every
///           vote is Unknown. Until it is sure, Dynamic is only what follows no other likely motion. A
///           feature with one depth is judged by its place in the image, one without by the line on which it
///           may lie (motion/static_miss.hpp). With stereo the line never says Static.
/// Needs:    depth, camera, correspondences. Optional: the host's poses (one more candidate), a motion prior.
/// Abstains: on the first frame; where no motion explains enough; where the background is uncertain; on
///           features without evidence of their own or of neighbours; on features that move alone.
/// Blind to: motion within the noise over 0.2 s; motion at an occluding edge as small as the shift of its two
///           surfaces; movers that were never matched, where it was hidden or where they cover it; movers of
///           fewer than three features; everything, if a mover is taken for the background.
/// State:    the camera's last motions, ratios of the noise, evidence and mobility per track; 12 frames.
class BackgroundMotionFilter final : public NamedFilter<BackgroundMotionFilter> {
 public:
  using Params = BackgroundMotionParams;
  static constexpr const char* kName = "background_motion";
  static constexpr const char* kSummary =
      "features that do not follow the background, also where movers have most features";

  explicit BackgroundMotionFilter(Params params = Params());

  Needs needs() const override {
    return {Input::Depth | Input::Camera | Input::Correspondence, Input::Pose,
            static_cast<int>(CameraPath::kMaxFrames)};
  }
  void reset() override;
  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static constexpr TrackOptions kTracks{static_cast<int>(CameraPath::kMaxFrames), 3.0, true};
  static constexpr double kDepthFactor = 2;        ///< the depth camera's noise against the model's, at least
  static constexpr float kRejectCost_nats = 3.5F;  ///< of a wrong rejection over a miss, logarithm
  static constexpr float kNoMatch_nats = 2;        ///< if the last frame was not judged: movers lose matches
  static constexpr double kDoubtedSigmas = 3;      ///< a miss beyond is looked at twice
  static constexpr std::size_t kMinSeeds = 30;
  static constexpr std::size_t kEnoughFirm = 100;      ///< matches that tell of the background's motion
  static constexpr double kLeastConfidence = 1.0 / 3;  ///< in the background: three motions equally likely
  static constexpr double kLikelyConfidence = 0.5;  ///< of the first one, at least: likelier than the others
  static constexpr double kSureConfidence = 0.6;    ///< to be sure
  static constexpr double kSureNextConfidence = 0.9;  ///< of the two after the first: scores are sharper
  static constexpr double kSureDespiteRows = 0.99;    ///< of the first three, where rows may have parted two
  static constexpr std::size_t kFirstSteps = 4;

  /// Whether the background is known, and what it takes to believe so. One that is not sure rejects only what
  /// follows no rival.
  struct Choice {
    bool known = false, is_first = false, is_sure = true;
    double least_confidence = kLeastConfidence;
    /// Motion that was seen against it.
    bool forgets() const { return is_first && !is_sure; }
  };

  void judge(const detail::JudgedFrame& seen, Votes& votes);
  /// Most of what seems to move where features jump far, as with stereo on a street, are mismatches.
  const Match& look_again(const detail::JudgedFrame& frame);
  Choice follow_background(const detail::JudgedFrame& frame, Votes& votes);
  RigidBackgroundScene scene_of(const detail::JudgedFrame& frame);
  void collect_seeds(const detail::JudgedFrame& frame);
  /// Nothing is rejected against a background that is probably a mover, and nothing is learned.
  void abstain(Votes& votes);
  /// Weight of what is judged against this background.
  float certainty() const { return static_cast<float>(std::max(0.0, 2 * estimator_.confidence() - 1)); }

  void weigh(const detail::JudgedFrame& frame, const DepthNoise& depths);
  /// What the last frame saw, and the oldest one within the window.
  void open_views(const detail::JudgedFrame& frame, const DepthNoise& depths);
  /// The place of a feature that was not matched may have been free. 0: no view says so.
  float space_odds(const cv::Point3f& point_m) const;
  /// Evidence of motion that the last frame expects at a feature [nats]. 0: none.
  float forecast(const detail::JudgedFrame& frame, std::size_t i) const;
  void learn_forecast(const detail::JudgedFrame& frame, float limit);
  /// What the belief must exceed. The more features move in this frame, the likelier is each.
  float limit_nats() const;
  void cast(const detail::JudgedFrame& frame, std::size_t i, const Choice& choice, float limit,
            Votes& votes) const;
  /// It moves whichever of the likely motions is the background's.
  bool follows_no_rival(const detail::JudgedFrame& frame, std::size_t i) const;
  void note_motion(const RigidMotion& motion, Votes& votes) const;

  Params params_;
  bool has_chosen_ = false;  ///< a motion, for the background
  RigidBackgroundEstimator estimator_;
  PriorWatch prior_watch_;
  CameraPath path_;
  detail::TrackMemory memory_;
  detail::TrackMisses misses_;
  detail::MissNoise noise_;
  std::vector<FreeSpaceView> views_;
  MoverForecast forecast_;
  detail::FeatureOdds odds_;
  detail::NeighbourVotes neighbours_;
  std::vector<int> seeds_, firm_;
  std::vector<MoverForecast::Seen> to_forecast_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/background_motion-inl.hpp>
#endif
