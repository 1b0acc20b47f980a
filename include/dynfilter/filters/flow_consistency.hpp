// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/motion/expiring.hpp>
#include <dynfilter/motion/flow_groups.hpp>
#include <dynfilter/motion/ground_contact.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <dynfilter/motion/prior_evidence.hpp>
#include <dynfilter/motion/view_motion.hpp>
#include <dynfilter/motion/view_motion_search.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

struct FlowConsistencyParams {
  /// Largest deviation of a static feature's flow, in standard deviations.
  static constexpr double kLimit = 2.0;
  double max_gap_s = 1.0;
  /// Longest gap over which flow is measured; the filter keeps its own tracks over it.
  static constexpr int kGapFrames = 30;
  static constexpr double kMemory_s = 0.5;  ///< Time constant of the average of a track's evidence.
  /// Smallest noise of a flow; larger noise is measured.
  static constexpr double kNoise_px = 0.15;
  static constexpr double kNoiseOfFlow = 0.01;  ///< Additional noise per pixel of flow.
  /// Largest distance from its epipolar line of a point that supports a camera motion.
  static constexpr double kMaxDistance_px = 1.0;
  bool ground = true;
  /// Focal length in image widths if no camera is given.
  static constexpr double kFocalOfWidth = 0.8;

  static const FieldTable<FlowConsistencyParams>& fields();
};

/// Rejects features whose flow over several time gaps differs from that of the static scene.
/// Needs no depth. docs/reference/filters/flow_consistency.md has the derivation.
///
/// Formula:  The camera's rotation and direction over a gap are estimated from flow, as the motion that
///           covers most of the image (motion/view_motion_search.hpp). Per feature, two medians are taken
///           over itself and its neighbours with similar flow. One is of the distance from the epipolar line.
///           The other is of the flow against the direction of static points, or of what exceeds five times
///           the flow of the middle of the scene along it. Both are in standard deviations, averaged over
///           time and over the group. Each feature is judged over the longest gap that its track covers. A
///           feature without a track has the mean excess over the limit of its neighbours. While the camera
///           drives forward, groups that do not stand on the ground are dynamic, too: cars ahead seem to be
///           beneath it, oncoming ones to hover (motion/ground_contact.hpp).
/// Needs:    correspondences from frame to frame. Optional: a camera, else a focal length is assumed, and the
///           turn of a motion prior.
/// Abstains: on features without a track whose neighbours do not move, with fewer than 12 tracks,
///           and if the tracks cover less than 5 of 72 cells of the image.
/// Blind to: movers along their epipolar line that seem no nearer than that, without `ground` or where the
///           ground is not seen;
///           a mover that covers more of the image than the background does.
/// State:    own tracks over up to 30 frames and their evidence; the last motion and ground. The pipeline
///           keeps one earlier frame.
/// Cost:     about 1.1 ms for 320 features, 3.3 ms for 1280, without flow.
class FlowConsistencyFilter final : public NamedFilter<FlowConsistencyFilter> {
 public:
  using Params = FlowConsistencyParams;
  static constexpr const char* kName = "flow_consistency";
  static constexpr const char* kSummary = "features whose flow differs from that of the static scene (mono)";

  explicit FlowConsistencyFilter(Params params = Params());

  Needs needs() const override { return {Input::Correspondence, Input::Camera, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override;
  void reset() override;

 private:
  /// Evidence of a track [sigma]: of its flow, and of its distance from the ground.
  struct TrackEvidence {
    ExpiringMean flow, off_ground;
  };
  /// A motion and its duration.
  struct TimedMotion {
    ViewMotion motion;
    double gap_s;

    /// The motion over another time at the same speed.
    ViewMotion over(double other_s) const;
  };
  struct PlacedFeature {
    cv::Point2d now;
    std::size_t feature;
  };
  /// A feature that can be judged over the current gap.
  struct Point {
    int feature;
    ViewPair pair;
    ViewFlow flow;
    double length_px;
    bool seed;
    double across_noise = 1, along_noise = 1;  ///< of the flow across and along its line, 1: of a corner
  };
  /// Deviations of a corner from which on a flow across its line says nothing. A match that slides meets
  /// other places of its edge, and no variance describes how far.
  static constexpr double kMostNoise = 3;
  /// Between frames whose timestamps do not increase.
  static constexpr double kUnknown_s = 1.0 / 30;
  /// Share of the tracks that cover the longest gap.
  static constexpr double kMostTracks = 0.5;
  /// Short, because near ground soon leaves the view.
  static constexpr double kGroundGap_s = 0.2;
  static constexpr double kMaxSigmas = 6;  ///< Limits the influence of one frame.
  static constexpr int kNeighbours = 6;    ///< judged together if their flow is similar
  static constexpr double kReach = 0.05;   ///< [image widths] radius of the neighbourhood
  /// Largest difference of similar flows.
  static constexpr double kAlike_px = 0.4, kAlikeOfFlow = 0.06;
  static constexpr double kUntrackedReach = 0.075;  ///< Neighbourhood of a feature without a track.
  static constexpr float kOwnWeight = 0.5F;         ///< of no excess in the mean over neighbours
  static constexpr std::size_t kGroup = 4;          ///< smallest number of points
  /// What moves along its line seems to be nearer or farther than it is. Static things are seldom nearer than
  /// a fifth of the middle of the scene. Movers often seem to be, because a walker is faster than a camera in
  /// the hand.
  static constexpr double kNearest = 5;
  static constexpr std::size_t kLeastCells = 9;           ///< that tell the middle of the scene
  static constexpr int kCellColumns = 12, kCellRows = 6;  ///< of the image, each with one vote

  void follow(const Evidence& evidence);
  void take_over_evidence();

  double gap_s(int gap) const { return ages_s_[static_cast<std::size_t>(gap)]; }

  void take_over_turns(const Evidence& evidence, const Match& match);
  /// Of the camera since the frame `gap` frames ago, if every step has a prior that can be trusted.
  std::optional<ViewTurn> turn_over(int gap) const;

  /// Selects the longest gap that most tracks cover, its half, its quarter and so on, and the gap for the
  /// ground. Longest first.
  void choose_gaps();

  bool needs_gap(int gap) const;

  /// Estimates the camera's motion over the gap, and each flow relative to it. False if there is no motion.
  bool measure(const Evidence& evidence, int gap, Votes& votes);

  void set_noise(Point& p) const;  ///< of the flow of a match that slides along an edge
  void note(int gap, const std::optional<ViewMotion>& found, Votes& votes) const;

  /// Sets principal point, focal length and image size.
  /// Without a camera or an image, uses the extent of the features.
  void set_view(const Evidence& evidence);

  /// False for NaN and for positions outside any image.
  static bool within(const cv::Point2f& px) { return std::abs(px.x) < 1e5F && std::abs(px.y) < 1e5F; }
  cv::Point2d centred(const cv::Point2f& px) const {
    return {static_cast<double>(px.x) - centre_.x, (static_cast<double>(px.y) - centre_.y) * y_scale_};
  }

  /// Sorts by current position, so that the result does not depend on the features' order.
  void sort_features();

  void collect_points(const Evidence& evidence, int gap);

  /// Two flows are similar if a common depth and a common distance from the epipolar line explain both.
  void group();
  static double line_length(const ViewFlow& flow) {
    return flow.inverse_depth != 0 ? flow.along_px / flow.inverse_depth : 0;
  }

  /// 1.48 times the median distance of the points that agree with the motion.
  double measured_noise_px();

  /// Of the middle of the static scene: median over the image's cells of each cell's median.
  /// Infinite without a baseline, or if fewer than kLeastCells are left.
  double middle_inverse_depth();
  /// Flow along the line that no static point has: against its direction, or as if it were too near.
  double wrong_way_px(const Point& p, double along_px, double middle_inverse_depth) const;

  void weigh_flows();

  TrackEvidence& evidence_of(std::size_t k) {
    return evidence_[static_cast<std::size_t>(points_[k].feature)];
  }
  bool judged(std::size_t k) const { return judged_[static_cast<std::size_t>(points_[k].feature)]; }

  /// A feature in a group has the suspicion of the group. Any other feature is scaled by the share of
  /// suspects among its neighbours, because a feature that moves alone is probably a bad track.
  void weigh_groups();

  double share_of_suspects(std::size_t k);

  /// Cosine: moves within 14 degrees of the optical axis.
  static constexpr double kAhead = 0.97;
  /// The camera drives if four fifths of its recent motion were ahead. A hand moves ahead, too, but seldom
  /// for so long: with this time constant, the share is reached after 0.4 s.
  static constexpr double kDrives = 0.8, kDriveMemory_s = 0.25;
  /// Tracks too young to be compared with the ground take over what similar neighbours have, in as many
  /// steps.
  static constexpr int kInferenceSteps = 3;
  static constexpr std::size_t kInferenceNeighbours = 2;

  /// Only a camera that drives forward has its horizon in the image and ground below it.
  bool find_focus();
  bool drives() const { return ahead_.value() >= kDrives; }

  void weigh_ground();
  void infer_ground_distances();
  void infer_ground_distances_once();
  void spread(const Evidence& evidence);
  /// Mean excess of the neighbours, near ones first: a body has features whose tracks have just begun.
  float mean_around(const Evidence& evidence, std::size_t i) const;
  void vote(const Evidence& evidence, Votes& votes);

  Params params_;
  const FeatureTracks* tracks_ = nullptr;  ///< of the current frame
  ViewMotionEstimator estimator_;
  FlowGroups groups_;
  GroundContact ground_;
  std::optional<TimedMotion> motion_;  ///< over the current gap
  Expiring<TimedMotion> main_motion_;  ///< over the last frame's longest gap
  ExpiringMean ahead_;                 ///< share of the recent frames in which the camera moved ahead
  std::vector<double> ages_s_;         ///< age of each recent frame
  std::vector<std::optional<MotionPrior>> steps_;  ///< priors of the recent steps, newest first
  PriorWatch prior_watch_;
  std::vector<int> gaps_;  ///< [frames]
  int ground_gap_ = 0;
  double gap_s_ = 0, passed_s_ = 0, noise_px_ = 0;

  cv::Size2d extent_;
  ImageCells<double> cells_{0, 0, kCellColumns, kCellRows, 0.5};  ///< of positions from the middle
  cv::Point2d centre_, focus_;
  double focal_px_ = 1, y_scale_ = 1;
  std::vector<TrackEvidence> evidence_, last_evidence_;
  std::vector<PlacedFeature> order_;
  std::vector<Point> points_;
  std::vector<ViewPair> pairs_;
  std::vector<cv::Point2d> places_;
  std::vector<GroundedPoint> grounded_;
  std::vector<int> seeds_, counts_;
  std::vector<bool> judged_, compared_;
  std::vector<std::size_t> inferred_;
  NeighbourPlaces neighbours_;
  NeighbourPlaces::Field excess_around_;
  std::vector<float> excess_, depths_m_;  ///< over the limit, in standard deviations; depths: unknown
  std::vector<double> suspicion_, values_, along_, inverse_depths_;
  CellLists in_cell_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/flow_consistency-inl.hpp>
#endif
