// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/geometry/flow_groups.hpp>
#include <dynfilter/geometry/ground_plane.hpp>
#include <dynfilter/geometry/view_motion.hpp>
#include <dynfilter/geometry/view_motion_search.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace dynfilter {

struct FlowConsistencyParams {
  double limit = 2.0;
  double max_gap_s = 1.0;
  int gap_frames = 30;
  double memory_s = 0.5;
  double noise_px = 0.15;
  double noise_of_flow = 0.01;
  double max_distance_px = 1.0;
  bool ground = true;
  double focal_of_width = 0.8;

  static const FieldTable<FlowConsistencyParams>& fields() {
    using P = FlowConsistencyParams;
    static const FieldTable<P> table{
        real("limit", &P::limit, "sigma", {0, 1e6},
             "largest deviation of a static feature's flow, in standard deviations"),
        real("max_gap_s", &P::max_gap_s, "s", {0, 100},
             "longest time over which flow is measured; less while most tracks are younger"),
        integer("gap_frames", &P::gap_frames, "frames", {1, 300},
                "longest gap over which flow is measured; the filter keeps its own tracks over it"),
        real("memory_s", &P::memory_s, "s", {0, 1000}, "time constant of the average of a track's evidence"),
        real("noise_px", &P::noise_px, "px", {0.001, 100},
             "smallest noise of a flow; larger noise is measured"),
        real("noise_of_flow", &P::noise_of_flow, "px/px", {0, 1}, "additional noise per pixel of flow"),
        real("max_distance_px", &P::max_distance_px, "px", {0.01, 100},
             "largest distance from its epipolar line of a point that supports a camera motion"),
        flag("ground", &P::ground,
             "groups with a lower end above the ground are dynamic; used only while the camera drives "
             "forward"),
        real("focal_of_width", &P::focal_of_width, "widths", {0.1, 10},
             "focal length in image widths if no camera is given"),
    };
    return table;
  }
};

/// Rejects features whose flow over several time gaps differs from that of the static scene.
/// Needs no depth. docs/reference/filters/flow_consistency.md has the derivation.
///
/// Formula:  The camera's rotation and direction over a gap are estimated from flow,
///           as the motion that covers most of the image (geometry/view_motion_search.hpp).
///           Per feature, two medians are taken over itself and its neighbours with similar flow.
///           One is of the distance from the epipolar line.
///           The other is of the flow against the direction of static points.
///           Both are in standard deviations, averaged over time and over the group.
///           Each feature is judged over the longest gap that its track covers.
///           In addition, groups whose lower end is above the ground are dynamic.
///           This detects objects that approach along the epipolar line.
/// Needs:    correspondences from frame to frame.
///           Optional: a camera, else a focal length is assumed.
/// Abstains: on features without a track, with fewer than 12 tracks,
///           and if the tracks cover less than 5 of 72 cells of the image.
/// Blind to: movers along their epipolar line with an invisible lower end or without `ground`;
///           a mover that covers more of the image than the background does.
/// State:    own tracks over up to gap_frames frames and their evidence;
///           the last motion and ground.
///           The pipeline keeps one earlier frame.
/// Cost:     about 1.1 ms for 320 features, 3.3 ms for 1280, without flow.
class FlowConsistencyFilter final : public Filter {
 public:
  using Params = FlowConsistencyParams;
  static constexpr const char* kName = "flow_consistency";
  static constexpr const char* kSummary = "features whose flow differs from that of the static scene (mono)";

  explicit FlowConsistencyFilter(Params params = Params()) : params_(params) {
    check_parameters(params_, kName);
    ViewMotionOptions options;
    options.max_distance_px = params_.max_distance_px;
    estimator_ = ViewMotionEstimator(options);
  }

  std::string name() const override { return kName; }
  Needs needs() const override { return {Input::Correspondence, Input::Camera, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    follow(evidence);
    set_view(evidence);
    choose_gaps();
    sort_features();
    for (const int gap : gaps_) {
      if (!somebody_needs(gap) || !measure(evidence, gap, votes)) continue;
      group();
      weigh_flows();
      weigh_groups();
      if (gap == ground_gap_) weigh_ground();
    }
    vote(evidence, votes);
  }

  void reset() override {
    evidence_.clear();
    ages_s_.clear();
    motion_.reset();
    main_motion_.reset();
    ground_.reset();
    extent_ = {};
  }

 private:
  /// Evidence of a track: exponential averages for its flow and for its height above the ground.
  struct TrackEvidence {
    double flow = 0, hanging = 0;
    bool flow_known = false, hanging_known = false;
  };
  /// A motion and its duration.
  struct TimedMotion {
    ViewMotion motion;
    double gap_s;

    /// The motion over another time at the same speed.
    ViewMotion over(double other_s) const {
      ViewMotion scaled = motion;
      for (double& w : scaled.rotation_rad) w *= other_s / gap_s;
      return scaled;
    }
  };
  struct PlacedFeature {
    ImageNeighbours::Point now;
    std::size_t feature;
  };
  /// A feature that can be judged over the current gap.
  struct Point {
    int feature;
    ViewPair pair;
    ViewFlow flow;
    double length_px;
    bool seed;
  };
  /// Between frames whose timestamps do not increase.
  static constexpr double kUnknown_s = 1.0 / 30;
  /// Share of the tracks that cover the longest gap.
  static constexpr double kMostTracks = 0.5;
  /// Short, because near ground soon leaves the view.
  static constexpr double kGroundGap_s = 0.2;
  static constexpr double kMaxSigmas = 6;  ///< limits the influence of one frame
  static constexpr int kNeighbours = 6;    ///< judged together if their flow is similar
  static constexpr double kReach = 0.05;   ///< [image widths] radius of the neighbourhood
  /// Largest difference of similar flows.
  static constexpr double kAlike_px = 0.4, kAlikeOfFlow = 0.06;
  static constexpr std::size_t kGroup = 4;  ///< smallest number of points

  void follow(const Evidence& evidence) {
    const Match& match = evidence.match({false, 1});
    tracks_ = &evidence.tracks({params_.gap_frames});
    double passed_s = match.reference ? evidence.frame().timestamp_s - match.reference->timestamp_s : 0;
    if (!(passed_s > 0)) passed_s = kUnknown_s;
    for (double& age_s : ages_s_) age_s += passed_s;
    ages_s_.insert(ages_s_.begin(), 0);
    ages_s_.resize(std::min(ages_s_.size(), static_cast<std::size_t>(params_.gap_frames) + 1));
    keep_ = params_.memory_s > 0 ? std::exp(-passed_s / params_.memory_s) : 0;
    take_over_evidence();
  }

  void take_over_evidence() {
    std::swap(evidence_, last_evidence_);
    const std::size_t n = tracks_->size();
    evidence_.assign(n, TrackEvidence());
    for (std::size_t i = 0; i < n; ++i) {
      const int previous = tracks_->previous(i);
      if (previous >= 0 && static_cast<std::size_t>(previous) < last_evidence_.size())
        evidence_[i] = last_evidence_[static_cast<std::size_t>(previous)];
    }
    judged_.assign(n, false);
    suspicion_.assign(n, 0);
  }

  double gap_s(int gap) const { return ages_s_[static_cast<std::size_t>(gap)]; }

  /// Selects the longest gap that most tracks cover, its half, its quarter and so on,
  /// and the gap for the ground. Longest first.
  void choose_gaps() {
    counts_.assign(ages_s_.size() + 1, 0);
    for (std::size_t i = 0; i < tracks_->size(); ++i)
      for (int k = 1; k <= tracks_->length(i) && k < static_cast<int>(ages_s_.size()); ++k)
        ++counts_[static_cast<std::size_t>(k)];
    gaps_.clear();
    ground_gap_ = 0;
    if (ages_s_.size() < 2 || counts_[1] == 0) return;
    const auto within = [&](int gap, double limit_s) {
      return gap < static_cast<int>(ages_s_.size()) && gap_s(gap) <= limit_s * (1 + 1e-6);
    };
    int longest = 1;
    while (within(longest + 1, params_.max_gap_s) &&
           counts_[static_cast<std::size_t>(longest) + 1] >= kMostTracks * counts_[1])
      ++longest;
    for (int gap = longest; gap > 0; gap /= 2) gaps_.push_back(gap);
    if (!params_.ground) return;
    ground_gap_ = 1;
    while (ground_gap_ < longest && within(ground_gap_ + 1, kGroundGap_s)) ++ground_gap_;
    gaps_.push_back(ground_gap_);
    std::sort(gaps_.rbegin(), gaps_.rend());
    gaps_.erase(std::unique(gaps_.begin(), gaps_.end()), gaps_.end());
  }

  bool somebody_needs(int gap) const {
    if (gap == gaps_.front() || gap == ground_gap_) return true;
    for (std::size_t i = 0; i < tracks_->size(); ++i)
      if (!judged_[i] && tracks_->length(i) >= gap) return true;
    return false;
  }

  /// Estimates the camera's motion over the gap, and each flow relative to it.
  /// False if there is no motion.
  bool measure(const Evidence& evidence, int gap, Votes& votes) {
    gap_s_ = gap_s(gap);
    collect_points(evidence, gap);
    seeds_.clear();
    pairs_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      pairs_.push_back(points_[k].pair);
      if (points_[k].seed) seeds_.push_back(static_cast<int>(k));
    }
    const bool main = gap == gaps_.front();
    if (main) motion_ = main_motion_;
    std::optional<ViewMotion> guess;
    if (motion_) guess = motion_->over(gap_s_);
    const std::optional<ViewMotion> found = estimator_.estimate(pairs_, seeds_, cells_, focal_px_, guess);
    if (main) {
      main_motion_.reset();
      if (found) main_motion_ = TimedMotion{*found, gap_s_};
      note(gap, found, votes);
    }
    if (!found) return false;
    motion_ = TimedMotion{*found, gap_s_};
    const ViewFlowModel model(*found);
    for (Point& p : points_) {
      p.flow = model(p.pair);
      p.length_px = p.flow.length_px();
    }
    noise_px_ = measured_noise_px();
    return true;
  }

  void note(int gap, const std::optional<ViewMotion>& found, Votes& votes) const {
    votes.note(!found ? "model: none, " + std::to_string(seeds_.size()) + " seeds with a track"
                      : std::string("model: ") +
                            (found->has_baseline() ? "rotation and direction" : "rotation") + " over " +
                            std::to_string(gap) + " frames, " + std::to_string(points_.size()) + " features");
  }

  /// Sets principal point, focal length and image size.
  /// Without a camera or an image, uses the extent of the features.
  void set_view(const Evidence& evidence) {
    for (const cv::Point2f& px : evidence.pixels()) {
      if (!within(px)) continue;
      extent_.width = std::max(extent_.width, static_cast<double>(px.x));
      extent_.height = std::max(extent_.height, static_cast<double>(px.y));
    }
    const FrameView& frame = evidence.frame();
    cv::Size2d size = extent_;
    if (!frame.grey.empty())
      size = {static_cast<double>(frame.grey.cols), static_cast<double>(frame.grey.rows)};
    else if (frame.camera && frame.camera->width_px > 0 && frame.camera->height_px > 0)
      size = {static_cast<double>(frame.camera->width_px), static_cast<double>(frame.camera->height_px)};
    cells_.width_px = std::max(1.0, size.width);
    cells_.height_px = std::max(1.0, size.height);
    centre_ = {size.width / 2, size.height / 2};
    focal_px_ = params_.focal_of_width * cells_.width_px;
    y_scale_ = 1;
    if (!frame.camera || !frame.camera->valid()) return;
    centre_ = {frame.camera->cx_px, frame.camera->cy_px};
    focal_px_ = frame.camera->fx_px;
    y_scale_ = frame.camera->fx_px / frame.camera->fy_px;
  }

  /// False for NaN and for positions outside any image.
  static bool within(const cv::Point2f& px) { return std::abs(px.x) < 1e5F && std::abs(px.y) < 1e5F; }
  ImageNeighbours::Point centred(const cv::Point2f& px) const {
    return {static_cast<double>(px.x) - centre_.x, (static_cast<double>(px.y) - centre_.y) * y_scale_};
  }

  /// Sorts by current position, so that the result does not depend on the features' order.
  void sort_features() {
    order_.clear();
    for (std::size_t i = 0; i < tracks_->size(); ++i)
      if (tracks_->length(i) > 0 && within(tracks_->at(i, 0)))
        order_.push_back({centred(tracks_->at(i, 0)), i});
    std::sort(order_.begin(), order_.end(), [](const PlacedFeature& a, const PlacedFeature& b) {
      return std::tie(a.now.x, a.now.y, a.feature) < std::tie(b.now.x, b.now.y, b.feature);
    });
  }

  void collect_points(const Evidence& evidence, int gap) {
    points_.clear();
    for (const auto& [now, i] : order_) {
      if (tracks_->length(i) < gap || !within(tracks_->at(i, gap))) continue;
      const ImageNeighbours::Point then = centred(tracks_->at(i, gap));
      points_.push_back({static_cast<int>(i), {then.x, then.y, now.x, now.y}, {}, 0, evidence.seed(i)});
    }
    const auto before = [](const Point& p, const Point& q) {
      return std::tie(p.pair.x, p.pair.y, p.pair.reference_x, p.pair.reference_y) <
             std::tie(q.pair.x, q.pair.y, q.pair.reference_x, q.pair.reference_y);
    };
    // Only features at the same position may still be out of order.
    if (!std::is_sorted(points_.begin(), points_.end(), before))
      std::stable_sort(points_.begin(), points_.end(), before);
  }

  /// Two flows are similar if a common depth and a common distance from the epipolar line
  /// explain both.
  void group() {
    places_.clear();
    for (const Point& p : points_) places_.push_back({p.pair.x, p.pair.y});
    groups_.build(places_, kReach * cells_.width_px, kNeighbours, [&](std::size_t i, std::size_t j) {
      const Point &p = points_[i], &q = points_[j];
      const double along = motion_->motion.has_baseline()
                               ? (p.flow.inverse_depth - q.flow.inverse_depth) * 0.5 *
                                     (line_length(p.flow) + line_length(q.flow))
                               : p.flow.along_px - q.flow.along_px;
      const double limit = kAlike_px + kAlikeOfFlow * 0.5 * (p.length_px + q.length_px);
      const double across = p.flow.across_px - q.flow.across_px;
      return along * along + across * across < limit * limit;
    });
  }
  static double line_length(const ViewFlow& flow) {
    return flow.inverse_depth != 0 ? flow.along_px / flow.inverse_depth : 0;
  }

  double median_of(std::vector<double>& values) const {
    if (values.empty()) return 0;
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    if (values.size() % 2 == 1) return *half;
    return 0.5 * (*half + *std::max_element(values.begin(), half));
  }

  /// 1.48 times the median distance of the points that agree with the motion.
  double measured_noise_px() {
    values_.clear();
    for (const Point& p : points_)
      if (std::abs(p.flow.across_px) < params_.max_distance_px) values_.push_back(std::abs(p.flow.across_px));
    return std::max(params_.noise_px, 1.48 * median_of(values_));
  }

  void weigh_flows() {
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (judged(k)) continue;
      values_.assign(1, points_[k].flow.across_px);
      along_.assign(1, points_[k].flow.along_px);
      for (const int j : groups_.linked(k)) {
        values_.push_back(points_[static_cast<std::size_t>(j)].flow.across_px);
        along_.push_back(points_[static_cast<std::size_t>(j)].flow.along_px);
      }
      const double across = median_of(values_);
      double wrong_way = median_of(along_);
      if (motion_->motion.has_baseline()) wrong_way = std::min(0.0, wrong_way);
      const double sigma_px = std::hypot(noise_px_, params_.noise_of_flow * points_[k].length_px);
      TrackEvidence& evidence = evidence_of(k);
      remember(std::min(std::hypot(across, wrong_way) / sigma_px, kMaxSigmas), evidence.flow,
               evidence.flow_known);
    }
  }

  TrackEvidence& evidence_of(std::size_t k) {
    return evidence_[static_cast<std::size_t>(points_[k].feature)];
  }
  bool judged(std::size_t k) const { return judged_[static_cast<std::size_t>(points_[k].feature)]; }

  void remember(double sigmas, double& mean, bool& known) const {
    mean += (known ? 1 - keep_ : 1) * (sigmas - mean);
    known = true;
  }

  /// A feature in a group has the suspicion of the group.
  /// Any other feature is scaled by the share of suspects among its neighbours,
  /// because a feature that moves alone is probably a bad track.
  void weigh_groups() {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const std::vector<int>& members = groups_.group(g);
      values_.clear();
      for (const int m : members) values_.push_back(evidence_of(static_cast<std::size_t>(m)).flow);
      const double together = median_of(values_);
      for (const int m : members) {
        const auto k = static_cast<std::size_t>(m), i = static_cast<std::size_t>(points_[k].feature);
        if (judged_[i]) continue;
        suspicion_[i] = members.size() >= kGroup ? together : evidence_[i].flow * share_of_suspects(k);
      }
    }
    for (const Point& p : points_) judged_[static_cast<std::size_t>(p.feature)] = true;
  }

  double share_of_suspects(std::size_t k) {
    const std::vector<int>& near = groups_.near(k);
    const auto suspects = std::count_if(near.begin(), near.end(), [&](int j) {
      return evidence_of(static_cast<std::size_t>(j)).flow > params_.limit;
    });
    return near.empty() ? 0 : static_cast<double>(suspects) / static_cast<double>(near.size());
  }

  /// Cosine: moves within 14 degrees of the optical axis.
  static constexpr double kAhead = 0.97;
  static constexpr double kGroundSmoothing = 0.5;  ///< weight of a new frame's ground
  /// [heights] smallest distance below the horizon of points that show the ground.
  static constexpr double kGroundBelow = 0.08;
  /// [heights] smallest distance below the horizon of points compared with the ground.
  static constexpr double kGroupBelow = 0.04;
  /// [heights] a lower end this close to the image's lower edge is cut off.
  static constexpr double kEdge = 0.03;
  /// Inverse depth ~ rows^slope: 0 for upright, 1 for ground.
  static constexpr double kFlat = 0.5;
  static constexpr double kFoot = 0.1;  ///< quantile of a group's ratios
  /// Ratio to the ground's inverse depth from which a group is above the ground.
  static constexpr double kGroundRatio = 1.2;
  static constexpr double kRatioSigma = 0.15;  ///< of the logarithm of the ratio

  /// Only a camera that drives forward has its horizon in the image and ground below it.
  bool find_focus() {
    const auto& c = motion_->motion.direction;
    if (!motion_->motion.has_baseline() || !(c[2] > kAhead)) return false;
    focus_.x = static_cast<float>(motion_->motion.focal_px * c[0] / c[2]);
    focus_.y = static_cast<float>(motion_->motion.focal_px * c[1] / c[2]);
    return true;
  }

  GroundPoint ground_point(const Point& p) const {
    return {p.pair.reference_x - focus_.x, p.pair.reference_y - focus_.y, p.flow.inverse_depth,
            cells_.of(p.pair.x, p.pair.y)};
  }

  bool find_ground() {
    if (!find_focus()) return false;
    ground_points_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (evidence_of(k).flow < params_.limit) ground_points_.push_back(ground_point(points_[k]));
    GroundPlaneFinder::Options options;
    options.min_below_px = kGroundBelow * cells_.height_px;
    const std::optional<GroundPlane> found = ground_finder_.find(ground_points_, options);
    if (ground_) ground_->scale *= gap_s_ / ground_s_;  // in units of the camera's step
    ground_s_ = gap_s_;
    if (!found) return ground_.has_value();
    if (!ground_) ground_ = GroundPlane{found->scale, 0};
    ground_->scale += kGroundSmoothing * (found->scale - ground_->scale);
    ground_->tilt += kGroundSmoothing * (found->tilt - ground_->tilt);
    return true;
  }

  void weigh_ground() {
    if (!find_ground()) return;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const std::optional<double> hanging = hanging_sigmas(groups_.group(g));
      if (!hanging) continue;
      for (const int m : groups_.group(g)) {
        TrackEvidence& evidence = evidence_of(static_cast<std::size_t>(m));
        remember(*hanging, evidence.hanging, evidence.hanging_known);
      }
    }
  }

  /// Evidence that the group's lower end is nearer than the ground below it.
  /// Only for upright groups below the horizon whose lower end is in the image, else nullopt.
  std::optional<double> hanging_sigmas(const std::vector<int>& members) {
    if (members.size() < kGroup) return std::nullopt;
    values_.clear();
    double lowest_px = -1e9, sx = 0, sy = 0, sxx = 0, sxy = 0;
    int n = 0;
    for (const int m : members) {
      const Point& p = points_[static_cast<std::size_t>(m)];
      const GroundPoint at = ground_point(p);
      const double below = ground_->below(at.x, at.y);
      lowest_px = std::max(lowest_px, p.pair.y);
      if (!(below > kGroupBelow * cells_.height_px)) continue;
      values_.push_back(at.inverse_depth / below);
      if (!(at.inverse_depth > 0)) continue;
      const double x = std::log(below), y = std::log(at.inverse_depth);
      sx += x, sy += y, sxx += x * x, sxy += x * y, ++n;
    }
    const auto count = static_cast<double>(n);
    if (2 * values_.size() < members.size() || n < 3) return std::nullopt;
    if (lowest_px > (0.5 - kEdge) * cells_.height_px) return std::nullopt;
    const double spread = sxx - sx * sx / count;
    if (sxy - sx * sy / count > kFlat * spread) return std::nullopt;
    return sigmas_above_ground();
  }

  /// From the ratios in values_. With few points the lower end is uncertain.
  double sigmas_above_ground() {
    const auto count = static_cast<double>(values_.size());
    const auto foot = values_.begin() + static_cast<std::ptrdiff_t>(kFoot * count);
    std::nth_element(values_.begin(), foot, values_.end());
    const double ratio = *foot / ground_->scale;
    if (!(ratio > 0)) return 0;
    const double limit = kGroundRatio * (1 + 1 / count);
    return std::clamp(params_.limit + std::log(ratio / limit) / kRatioSigma, 0.0, kMaxSigmas);
  }

  void vote(const Evidence& evidence, Votes& votes) const {
    for (std::size_t i = 0; i < judged_.size(); ++i) {
      if (!judged_[i] || !evidence.judged(i)) continue;
      const double sigmas = std::hypot(suspicion_[i], evidence_[i].hanging);
      votes.cast(i, sigmas > params_.limit ? Vote::Dynamic : Vote::Static, suspicion(sigmas, params_.limit));
    }
  }

  Params params_;
  const FeatureTracks* tracks_ = nullptr;  ///< of the current frame
  ViewMotionEstimator estimator_;
  FlowGroups groups_;
  GroundPlaneFinder ground_finder_;
  /// Over the current gap; over the last frame's longest gap.
  std::optional<TimedMotion> motion_, main_motion_;
  std::optional<GroundPlane> ground_;
  std::vector<double> ages_s_;  ///< age of each recent frame
  std::vector<int> gaps_;       ///< [frames]
  int ground_gap_ = 0;
  double gap_s_ = 0, ground_s_ = 0, keep_ = 0, noise_px_ = 0;

  cv::Size2d extent_;
  ImageCells cells_;
  cv::Point2d centre_, focus_;
  double focal_px_ = 1, y_scale_ = 1;
  std::vector<TrackEvidence> evidence_, last_evidence_;
  std::vector<PlacedFeature> order_;
  std::vector<Point> points_;
  std::vector<ViewPair> pairs_;
  std::vector<ImageNeighbours::Point> places_;
  std::vector<GroundPoint> ground_points_;
  std::vector<int> seeds_, counts_;
  std::vector<bool> judged_;
  std::vector<double> suspicion_, values_, along_;
};

}  // namespace dynfilter
