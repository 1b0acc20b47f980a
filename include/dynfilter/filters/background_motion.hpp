// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
#include <dynfilter/motion/free_space.hpp>
#include <dynfilter/motion/mover_forecast.hpp>
#include <dynfilter/motion/moving_odds.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <dynfilter/motion/prior_evidence.hpp>
#include <dynfilter/motion/rigid_background.hpp>
#include <dynfilter/motion/row_twist.hpp>
#include <dynfilter/motion/static_miss.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

struct BackgroundMotionParams {
  static constexpr double kSlow_mps = 0.05;  ///< Speed of slow movers, standard deviation.
  static constexpr double kFast_mps = 1.0;   ///< Speed of fast movers, standard deviation.
  /// Share of features that move, before anything was measured.
  static constexpr double kMovingShare = 0.05;
  static constexpr double kMovingSuspects = 0.35;  ///< the same of features that a detector suspects
  static constexpr double kMemory_s = 0.036;       ///< Time constant of a track's belief.
  /// Time constant of having moved: a mover that stops is not yet background.
  static constexpr double kMobility_s = 2;
  /// Radius of the neighbourhood whose evidence is averaged.
  double neighbour_px = 25;
  /// Largest difference in depth within a neighbourhood.
  double neighbour_m = 0.12;

  static const FieldTable<BackgroundMotionParams>& fields();
};

/// Features that do not follow the background. The default rejector. It needs no detector.
///
/// Formula:  the background's motion is chosen among several (motion/rigid_background.hpp). Each feature's
///           residual against it in (u, v, depth) gives log-odds of motion (motion/moving_odds.hpp), over one
///           frame and over its track of up to 0.2 s. The larger count, but a miss that the track undoes does
///           not. In a patch over two surfaces their shift against each other is added to the noise
///           (motion/patch_relief.hpp), which is measured in every frame. Features without a match have those
///           of motion/free_space.hpp or, with stereo, motion/mover_forecast.hpp. Belief = odds + memory *
///           belief in the last frame, plus the mean over neighbours at a similar depth. Dynamic above the
///           log-odds against motion in this frame, if a core is near: a feature with evidence of motion
///           among others with such evidence. A prior suspect has a larger prior and needs no core.
/// Votes:    with a confidence, the probability that the chosen motion is the background's. Below 1/3 every
///           vote is Unknown. Stereo: a feature with one depth is judged by its place in the image, one
///           without by the line on which it may lie (motion/static_miss.hpp).
/// Needs:    depth, camera, correspondences. Optional: the host's poses (one more candidate), a motion prior.
/// Abstains: on the first frame; where no motion explains enough; where the background is uncertain; on
///           features without evidence of their own or of neighbours; on features that move alone.
/// Blind to: motion within the noise over 0.2 s; motion at an occluding edge as small as the shift of its two
///           surfaces; movers without matches at places that were hidden or that they cover; movers of
///           fewer than three features; everything, if a mover is taken for the background.
/// State:    the camera's last motions, the ratios of the noise, belief and mobility per track. 12 frames are
///           kept. Cost: see the card.
class BackgroundMotionFilter final : public NamedFilter<BackgroundMotionFilter> {
 public:
  using Params = BackgroundMotionParams;
  static constexpr const char* kName = "background_motion";
  static constexpr const char* kSummary =
      "features that do not follow the background, also where movers have most features";

  explicit BackgroundMotionFilter(Params params = Params());

  Needs needs() const override {
    return {Input::Depth | Input::Camera | Input::Correspondence, Input::Pose, static_cast<int>(kMaxFrames)};
  }
  void reset() override;
  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static constexpr std::size_t kMaxFrames = 12;  ///< That a track goes back, at most ...
  static constexpr TrackOptions kTracks{static_cast<int>(kMaxFrames), 3.0, true};
  static constexpr double kWindow_s = 0.2;                     ///< ... and in time
  static constexpr double kUnknownStep_s = 1.0 / 30;           ///< where stamps do not increase
  static constexpr float kLeastOdds = -3, kMostOdds = 6;       ///< of one frame [nats]
  static constexpr float kLeastLineOdds = -1;                  ///< a mover may keep to its epipolar line
  static constexpr float kLeastBelief = -4, kMostBelief = 10;  ///< [nats].
  /// Before any was measured.
  static constexpr double kFirstStepRatio = 1.5, kFirstTrackRatio = 3;
  static constexpr double kLeastRatio = 1.0, kMostStepRatio = NeighbourNoise::kMostShared,
                          kMostTrackRatio = 8;
  static constexpr double kRatioSlack = 1.5;  ///< A frame may exceed what is usual by this factor.
  static constexpr double kRatioFalls = 0.3, kRatioRises = 0.03;  ///< Share learned per frame.
  static constexpr double kLeastMatchNoise_px = 0.05;             ///< flow is not more exact
  /// Median of a miss in two axes over its sigma.
  static constexpr double kMedianOfRayleigh = 1.18;
  /// The depth camera's noise against the model's, at least.
  static constexpr double kDepthFactor = 2;
  static constexpr std::size_t kMinMeasured = 20;
  static constexpr float kNoiseReach_px = 30;
  // Features without evidence: how far their neighbourhood reaches, and the belief they must exceed [nats].
  // Without a depth they may lie on another surface than their neighbours.
  static constexpr float kUnseenReach = 2.5F, kUnseenLimit = 0, kSuspectLimit = -0.1F;
  static constexpr float kBlindReach = 1.5F, kBlindLimit = 0.6F;
  static constexpr float kMobilityReach = 1.2F;  ///< features that appear take mobility from as far
  static constexpr float kBlindTrust = 0.3F;     ///< of neighbours, for a feature without depth
  static constexpr float kOwnWeight = 0.5F;      ///< of zero evidence in the mean over neighbours
  static constexpr float kSupportReach_px = 40, kSupportReach_m = 0.25F;  ///< neighbours of a core
  static constexpr float kMinSupport = 1.3F;       ///< two of them within 24 px, or more farther away
  static constexpr float kMinSupportShare = 0.5F;  ///< Of them that must move, too.
  /// From a core to its object's features.
  static constexpr float kCoreReach_px = 120, kCoreReach_m = 0.4F;
  static constexpr double kReachSigmas = 3;  ///< Of two depths' noise.
  static constexpr int kMinSeeds = 30;
  static constexpr double kLeastConfidence = 1.0 / 3;  ///< in the background: three motions equally likely
  /// The same for the first choice, which is made again: likelier than all others together.
  static constexpr double kLeastFirstConfidence = 0.5;
  static constexpr double kSureFirstConfidence = 0.7;  ///< below, the first choices reject nothing ...
  static constexpr std::size_t kFirstPoses = 4;        ///< ... and no track is followed over them

  void judge(const Evidence& evidence, const Match& match, Votes& votes);
  /// Nothing is rejected against a background that is probably a mover, and nothing is learned.
  void abstain(const Evidence& evidence, Votes& votes);
  void forget_motion();
  float score(std::size_t i) const { return 1 / (1 + portable::exp(-belief_[i] / 2)); }

  /// Stamps of this frame and the last ones, newest first.
  void keep_time(const FrameView& frame);
  double elapsed_s(std::size_t frames) const;

  // ---- what is known from earlier frames
  void recall(const Evidence& evidence, const Match& match);

  /// What was judged against a background that may be the wrong one must not decide the next choice.
  float confidence_weight() const {
    return static_cast<float>(std::max(0.0, 2 * estimator_.confidence() - 1));
  }

  /// A feature without a past takes that of the features around the place where it was.
  float mobility_around(const Evidence& evidence, const Match& match, std::size_t i) const;

  void remember_mobility(const Evidence& evidence);
  /// Difference in depth of features on one surface: a stereo camera's noise alone exceeds any fixed one.
  float reach_m(double least_m, float depth_m) const;

  // ---- the background's motion
  bool follow_background(const Evidence& evidence, const Match& match, Votes& votes);

  void note_motion(Votes& votes) const;
  void note_slides(const Match& match, Votes& votes) const;
  static constexpr std::size_t kEnoughFirm = 100;  ///< matches that tell of the background's motion
  void drop_sliding_seeds(const Match& match);

  /// T_world_camera of the last frames, newest first; the world is the first camera.
  void remember_pose();
  /// The motion from frame to frame, over the last few: a mover that sets off slowly drags it away less.
  Pose usual_step() const;
  /// From the camera `then` frames back to that of `now` frames back.
  Pose between(std::size_t now, std::size_t then) const {
    return inverse(camera_poses_[now]) * camera_poses_[then];
  }

  // ---- misses
  struct Measured {
    int gap = 0;  ///< frames; 0: none
    SeenPoint then;
    float image_px = 0;
    StaticMiss::Axes axes = StaticMiss::Axes::None;
    MatchSpread spread;
    bool in_space() const { return axes == StaticMiss::Axes::Space; }
    /// Says for standing still, too. Movers on a road keep to their epipolar line.
    bool can_show_rest() const { return axes == StaticMiss::Axes::Space || axes == StaticMiss::Axes::Image; }
  };
  void measure_misses(const Evidence& evidence, const Match& match);
  void measure(const Evidence& evidence, std::size_t i, int gap, const SeenPoint& then,
               const MatchSpread& spread, Measured& out, std::vector<Miss>* misses);
  /// As all rows would have been seen at once, against the frame `gap` frames back.
  SeenPoint now(const Evidence& evidence, std::size_t i, int gap) const;
  /// A long slide along an edge misses across it, too: the edge's direction is not exact.
  MatchSpread spread_of(const MatchSpread& spread, const StaticMiss& miss, int gap) const;
  /// Noise that neighbours do not share, summed over the frames of a track.
  double chained_noise_px(std::size_t gap) const;
  RigidResidualNoise noise(double pixel_sigma_px) const;

  // ---- noise
  /// What a static feature's miss is, in units of chained_noise_px(): over one frame, and over a track.
  void measure_noise(const Evidence& evidence);
  static constexpr double kLeastTrackScale = 0.5, kMostTrackScale = 3;
  bool likely_static(std::size_t i) const { return mobility_[i] < RigidBackgroundEstimator::kMobile; }
  /// From the median in ratios_, in units of what neighbours do not share. Down fast, up slowly: a majority
  /// that sets off must not become noise.
  double usual(double base, double most, double& ratio);

  // ---- evidence
  void weigh_misses(const Evidence& evidence);
  double sigma_px(int gap) const {
    return (gap == 1 ? step_scale_ : track_scale_) * chained_noise_px(static_cast<std::size_t>(gap));
  }
  /// NaN: two surfaces in the patch explain what looks like motion, so nothing is said.
  float odds_of_match(const Evidence& evidence, std::size_t i, const MovingOdds& odds) const;
  float odds_with_relief(const Evidence& evidence, std::size_t i, double relief_per_m,
                         const MovingOdds& odds) const;
  double relief_per_m(const Evidence& evidence, std::size_t i) const;
  /// An error of the last frame's match: a mover misses more over its track.
  bool is_undone(std::size_t i) const {
    return step_[i].in_space() && track_[i].in_space() && track_[i].image_px < step_[i].image_px;
  }
  float odds_of(const Evidence& evidence, std::size_t i, const Measured& measured, double relief_per_m,
                const MovingOdds& odds) const;
  /// The part of the odds' input that is measured in the image. `shift_px`: of the patch's two surfaces.
  MovingOddsInput odds_in_image(const Measured& measured, const StaticMiss& miss, double shift_px) const;

  // ---- free space
  /// What the last frame saw, and the oldest one within the window.
  void open_views(const Evidence& evidence);
  void open_view(const Evidence& evidence, std::size_t gap);
  /// The place of a feature that was not matched may have been free. 0: no view says so.
  float space_odds(const cv::Point3f& point_m) const;

  // ---- what moved before
  /// Evidence of motion that the last frame expects at a feature [nats]. 0: none.
  float forecast(const Evidence& evidence, std::size_t i) const;
  /// With stereo, where features jump far.
  void learn_forecast(const Evidence& evidence);

  // ---- neighbours
  void add_neighbours(const Evidence& evidence);
  /// Mean evidence of the neighbours, near ones first.
  float mean_around(const Evidence& evidence, std::size_t i) const;

  /// A core moves, and so do most of its neighbours: a mismatch is alone.
  void find_cores(const Evidence& evidence);
  bool supported(const Evidence& evidence, std::size_t i) const;
  bool near_core(const Evidence& evidence, std::size_t i) const {
    return is_core_[i] != 0 ||
           places_.any_around(cores_, evidence.pixels()[i], evidence.depths_m()[i], kCoreReach_px,
                              reach_m(kCoreReach_m, evidence.depths_m()[i]));
  }

  void cast(const Evidence& evidence, std::size_t i, Votes& votes) const;

  /// What a feature with evidence must exceed: the log-odds against motion in this frame.
  void set_rest_log_odds();
  /// What a feature without evidence must exceed. Being suspect is enough with a depth, which the stage that
  /// suspects it can look at. Structured light has holes beside near surfaces, on what is behind them.
  float limit_without_evidence(const Evidence& evidence, std::size_t i) const;

  Params params_;
  const FeatureTracks* tracks_ = nullptr;  ///< of the current frame
  RigidBackgroundEstimator estimator_;
  PriorWatch prior_watch_;
  NeighbourNoise neighbour_noise_;
  RigidMotion motion_;
  std::vector<Pose> camera_poses_;
  std::vector<RowTwist> twists_;                   ///< of the last steps, newest first
  std::vector<RowTwist> twist_over_;               ///< their sums, over one step and more
  std::vector<double> stamps_s_, match_noise_px_;  ///< newest first
  std::vector<std::int64_t> frame_ids_;            ///< newest first
  std::size_t unbroken_ = 0;  ///< newest steps, each from the frame before, with a sure background
  double step_ratio_ = kFirstStepRatio, track_ratio_ = kFirstTrackRatio;
  double least_confidence_ = kLeastConfidence;
  bool first_choice_ = true, rejects_ = true;
  float rest_log_odds_ = 0;                  ///< [nats]
  double step_scale_ = 1, track_scale_ = 1;  ///< of chained_noise_px(), in this frame
  DepthNoise sensor_;                        ///< of this frame's depths
  bool judges_directions_ = false;           ///< features without depth have evidence of their own
  std::vector<StaticMissModel> models_;      ///< [g - 1]: over g frames
  std::vector<FreeSpaceView> views_;
  MoverForecast forecast_;
  std::vector<MoverForecast::Seen> to_forecast_;
  std::vector<Measured> step_, track_;
  std::vector<Miss> track_misses_;
  std::vector<float> ratios_;
  std::vector<int> seeds_, firm_;
  std::vector<float> remembered_, static_belief_, own_;
  std::vector<float> belief_, last_belief_;
  std::vector<std::uint8_t> seen_, is_core_;
  std::vector<float> mobility_, last_mobility_;
  NeighbourPlaces places_, last_places_;              ///< of the features, in this and the last frame
  NeighbourPlaces::Field evidence_, moving_, cores_;  ///< at places_
  NeighbourPlaces::Field moved_;                      ///< mobility at last_places_
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/background_motion-inl.hpp>
#endif
