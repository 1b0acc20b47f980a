// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/context/context.hpp>
#include <dynfilter/context/feature_tracks.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/geometry/background_motion.hpp>
#include <dynfilter/geometry/flow_groups.hpp>
#include <dynfilter/geometry/ground_plane.hpp>
#include <dynfilter/geometry/view_motion.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

struct FlowConsistencyParams {
  double limit = 2.0;
  int gap_frames = 4;
  double max_distance_px = 1.0;
  double noise_px = 0.15;
  double noise_of_flow = 0.004;
  double memory = 0.65;
  int neighbours = 6;
  double reach = 0.05;
  double alike_px = 0.4;
  double alike_of_flow = 0.06;
  bool ground = true;
  double ground_ratio = 1.2;
  double focal_of_width = 0.8;

  static const FieldTable<FlowConsistencyParams>& fields() {
    using P = FlowConsistencyParams;
    static const FieldTable<P> table{
        real("limit", &P::limit, "sigma", {0, 1e6},
             "dynamic beyond: how far a flow is from a static point's"),
        integer("gap_frames", &P::gap_frames, "frames", {1, 30},
                "flow over so many frames, over fewer while most tracks are younger"),
        real("max_distance_px", &P::max_distance_px, "px", {0.01, 100},
             "from its epipolar line, for a point to support a camera motion"),
        real("noise_px", &P::noise_px, "px", {0.001, 100}, "of a flow at least; more is measured"),
        real("noise_of_flow", &P::noise_of_flow, "px/px", {0, 1}, "more noise per pixel of flow"),
        real("memory", &P::memory, "", {0, 0.999}, "share of a track's evidence that outlives a frame"),
        integer("neighbours", &P::neighbours, "features", {1, 100}, "judged together if they flow alike"),
        real("reach", &P::reach, "widths", {0, 1}, "how far neighbours are, in widths of the image"),
        real("alike_px", &P::alike_px, "px", {0, 100}, "flows that differ by no more are alike"),
        real("alike_of_flow", &P::alike_of_flow, "px/px", {0, 10}, "the same per pixel of flow"),
        flag("ground", &P::ground, "a group that hangs above the ground moves: for cameras that drive"),
        real("ground_ratio", &P::ground_ratio, "", {1, 100},
             "a group hangs if its foot seems nearer than the ground there by this factor"),
        real("focal_of_width", &P::focal_of_width, "widths", {0.1, 10},
             "the focal length where no camera is known"),
    };
    return table;
  }
};

/// Mono: features whose flow over several frames is not that of the static scene. Of our own making; the card
/// has the derivation.
///
/// Formula:  the camera's turn and direction from flow over gap_frames frames, as the motion that covers most
/// of the
///           image (geometry/background_motion.hpp). Per feature, over itself and the neighbours that flow
///           alike: median distance from the epipolar line, median flow against the direction in which
///           static points flow, in sigmas; averaged over the track's life and with its group. Beside it:
///           groups whose foot hangs above the ground, as what comes along the epipolar line does.
/// Needs:    correspondences frame to frame. Optional: a camera (else a focal length is assumed).
/// Abstains: on features without a past, with fewer than 12 of them or on less than 5 of 72 cells of the
///           image.
/// Blind to: movers that keep to their epipolar line and show no foot (or with `ground: false`); whatever
///           covers more of the image than the background does.
/// State:    the tracks' last gap_frames places and their evidence, the last motion and ground. Cost: about
///           3.3 ms for 1150 features, flow not included.
class FlowConsistencyFilter final : public Filter {
 public:
  using Params = FlowConsistencyParams;
  static constexpr const char* kName = "flow_consistency";
  static constexpr const char* kSummary = "features whose flow is not the static scene's (mono)";

  explicit FlowConsistencyFilter(Params params = Params()) : params_(params), tracks_(params.gap_frames) {
    check_parameters(params_, kName);
    BackgroundMotionOptions options;
    options.max_distance_px = params_.max_distance_px;
    estimator_ = BackgroundMotionEstimator(options);
  }

  std::string name() const override { return kName; }
  Needs needs() const override { return {Input::Correspondence, Input::Camera, 1}; }

  void apply(Context& context, Votes& votes) override {
    const Match& match = context.match({false, 1});
    tracks_.follow(context.frame().id, match, context.pixels(), context.undistorted_pixels());
    take_over_evidence();
    if (!measure(context)) return;
    group();
    weigh_flows();
    find_ground();
    weigh_groups();
    vote(context, votes);
  }

  void reset() override {
    tracks_.reset();
    evidence_.clear();
    motion_.reset();
    ground_.reset();
    extent_ = {};
  }

 private:
  /// What a track was told so far: a mean that forgets, and one about hanging above the ground.
  struct Evidence {
    double flow = 0, flow_weight = 0, hanging = 0;
    bool hanging_known = false;
  };
  /// A feature that can be judged in this frame.
  struct Point {
    int feature;
    ViewPair pair;
    ViewFlow flow;
    double length_px;
    bool seed;
  };
  static constexpr double kMaxSigmas = 6;

  void take_over_evidence() {
    std::swap(evidence_, last_evidence_);
    const std::size_t n = tracks_.size();
    evidence_.assign(n, Evidence());
    for (std::size_t i = 0; i < n; ++i) {
      const int previous = tracks_.previous(i);
      if (previous >= 0 && static_cast<std::size_t>(previous) < last_evidence_.size())
        evidence_[i] = last_evidence_[static_cast<std::size_t>(previous)];
    }
  }

  /// The camera's motion and every flow against it. False: there is none.
  bool measure(Context& context) {
    const int gap = choose_gap();
    if (ground_) ground_->scale *= static_cast<double>(gap) / last_gap_;  // of the camera's step, which grows
    last_gap_ = gap;
    set_view(context);
    collect_points(context, gap);
    seeds_.clear();
    pairs_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      pairs_.push_back(points_[k].pair);
      if (points_[k].seed) seeds_.push_back(static_cast<int>(k));
    }
    motion_ = estimator_.estimate(pairs_, seeds_, cells_, focal_px_, motion_);
    if (!motion_) {
      context.note("model: none, " + std::to_string(seeds_.size()) + " seeds with a past");
      return false;
    }
    const ViewFlowModel model(*motion_);
    for (Point& p : points_) {
      p.flow = model(p.pair);
      p.length_px = p.flow.length_px();
    }
    gap_weight_ = static_cast<double>(gap) * gap;
    context.note(std::string("model: ") + (motion_->has_baseline() ? "turn and direction" : "turn") +
                 " over " + std::to_string(gap) + " frames, " + std::to_string(points_.size()) + " features");
    return true;
  }

  /// The longest that at least half of the tracks with any past have.
  int choose_gap() {
    counts_.assign(static_cast<std::size_t>(params_.gap_frames) + 1, 0);
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      for (int k = 1; k <= tracks_.length(i); ++k) ++counts_[static_cast<std::size_t>(k)];
    int gap = 1;
    while (gap < params_.gap_frames && 2 * counts_[static_cast<std::size_t>(gap) + 1] >= counts_[1]) ++gap;
    return gap;
  }

  /// Principal point, focal length and size of the image; without a camera or an image what the features
  /// span.
  void set_view(Context& context) {
    for (const cv::Point2f& px : context.pixels()) {
      if (!within(px)) continue;
      extent_.width = std::max(extent_.width, static_cast<double>(px.x));
      extent_.height = std::max(extent_.height, static_cast<double>(px.y));
    }
    const FrameView& frame = context.frame();
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

  /// False for NaN and for places that no image has.
  static bool within(const cv::Point2f& px) { return std::abs(px.x) < 1e5F && std::abs(px.y) < 1e5F; }
  ImageNeighbours::Point centred(const cv::Point2f& px) const {
    return {static_cast<double>(px.x) - centre_.x, (static_cast<double>(px.y) - centre_.y) * y_scale_};
  }

  /// In an order that does not depend on the features'.
  void collect_points(const Context& context, int gap) {
    points_.clear();
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      if (tracks_.length(i) < gap) continue;
      const cv::Point2f &now = tracks_.at(i, 0), &then = tracks_.at(i, gap);
      if (!within(now) || !within(then)) continue;
      const ImageNeighbours::Point a = centred(then), b = centred(now);
      points_.push_back({static_cast<int>(i), {a.x, a.y, b.x, b.y}, {}, 0, context.seed(i)});
    }
    std::stable_sort(points_.begin(), points_.end(), [](const Point& p, const Point& q) {
      if (p.pair.x != q.pair.x) return p.pair.x < q.pair.x;
      if (p.pair.y != q.pair.y) return p.pair.y < q.pair.y;
      if (p.pair.reference_x != q.pair.reference_x) return p.pair.reference_x < q.pair.reference_x;
      return p.pair.reference_y < q.pair.reference_y;
    });
  }

  /// Neighbours are alike whose flows a common depth and a common miss of the epipolar line explain.
  void group() {
    places_.clear();
    for (const Point& p : points_) places_.push_back({p.pair.x, p.pair.y});
    groups_.build(
        places_, params_.reach * cells_.width_px, params_.neighbours, [&](std::size_t i, std::size_t j) {
          const Point &p = points_[i], &q = points_[j];
          const double along = motion_->has_baseline() ? (p.flow.inverse_depth - q.flow.inverse_depth) * 0.5 *
                                                             (line_length(p.flow) + line_length(q.flow))
                                                       : p.flow.along_px - q.flow.along_px;
          const double limit = params_.alike_px + params_.alike_of_flow * 0.5 * (p.length_px + q.length_px);
          return std::hypot(along, p.flow.across_px - q.flow.across_px) < limit;
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

  /// 1.48 times the median distance of those that agree with the motion.
  double measured_noise_px() {
    values_.clear();
    for (const Point& p : points_)
      if (std::abs(p.flow.across_px) < params_.max_distance_px) values_.push_back(std::abs(p.flow.across_px));
    return std::max(params_.noise_px, 1.48 * median_of(values_));
  }

  void weigh_flows() {
    const double noise = measured_noise_px();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      values_.assign(1, points_[k].flow.across_px);
      along_.assign(1, points_[k].flow.along_px);
      for (const int j : groups_.linked(k)) {
        values_.push_back(points_[static_cast<std::size_t>(j)].flow.across_px);
        along_.push_back(points_[static_cast<std::size_t>(j)].flow.along_px);
      }
      const double across = median_of(values_);
      double wrong_way = median_of(along_);
      if (motion_->has_baseline()) wrong_way = std::min(0.0, wrong_way);
      const double of_flow = params_.noise_of_flow * points_[k].length_px;
      const double sigmas = std::hypot(across, wrong_way) / std::hypot(noise, of_flow);
      // Without company it may be a bad track.
      const double alone = groups_.linked(k).size() < 2 ? 0.5 : 1;
      remember(evidence_of(k), alone * std::min(sigmas, kMaxSigmas));
    }
  }

  Evidence& evidence_of(std::size_t k) { return evidence_[static_cast<std::size_t>(points_[k].feature)]; }

  void remember(Evidence& evidence, double sigmas) const {
    const double old = params_.memory * evidence.flow_weight;
    const double fresh = evidence.flow_weight > 0 ? (1 - params_.memory) * gap_weight_ : gap_weight_;
    evidence.flow = (old * evidence.flow + fresh * sigmas) / (old + fresh);
    evidence.flow_weight = old + fresh;
  }

  /// Where the camera goes: its step seen in the image. None for a camera that goes sideways.
  bool focus_of_expansion(double& x, double& y) const {
    const auto& c = motion_->direction;
    if (!(std::abs(c[2]) > 0.5)) return false;
    x = motion_->focal_px * c[0] / c[2];
    y = motion_->focal_px * c[1] / c[2];
    return true;
  }

  GroundPoint ground_point(const Point& p) const {
    return {p.pair.reference_x - focus_.x, p.pair.reference_y - focus_.y, p.flow.inverse_depth,
            cells_.of(p.pair.x, p.pair.y)};
  }

  void find_ground() {
    ground_usable_ = params_.ground && focus_of_expansion(focus_.x, focus_.y);
    if (!ground_usable_) return;
    ground_points_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (evidence_of(k).flow < params_.limit) ground_points_.push_back(ground_point(points_[k]));
    GroundPlaneFinder::Options options;
    options.min_below_px = 0.08 * cells_.height_px;
    const std::optional<GroundPlane> found = ground_finder_.find(ground_points_, options);
    if (found && ground_) {
      ground_->scale += 0.5 * (found->scale - ground_->scale);
      ground_->tilt += 0.3 * (found->tilt - ground_->tilt);
    } else if (found) {
      ground_ = GroundPlane{found->scale, 0.3 * found->tilt};
    }
    ground_usable_ = ground_.has_value();
  }

  void weigh_groups() {
    suspicion_.resize(points_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const std::vector<int>& members = groups_.group(g);
      const std::optional<double> hanging = hanging_sigmas(members);
      values_.clear();
      for (const int m : members) values_.push_back(evidence_of(static_cast<std::size_t>(m)).flow);
      const double together = median_of(values_);
      for (const int m : members) {
        const auto k = static_cast<std::size_t>(m);
        Evidence& evidence = evidence_of(k);
        if (hanging) {
          const double share = evidence.hanging_known ? 1 - params_.memory : 1;
          evidence.hanging += share * (*hanging - evidence.hanging);
          evidence.hanging_known = true;
        }
        const double flow =
            members.size() >= 4 ? 0.5 * (together + evidence.flow) : evidence.flow * trust_in_few(k);
        suspicion_[k] = std::hypot(flow, evidence.hanging);
      }
    }
  }

  /// A feature that flows like few others counts in full among suspects only.
  double trust_in_few(std::size_t k) {
    int suspects = 0, all = 0;
    for (const int j : groups_.near(k)) {
      ++all;
      suspects += evidence_of(static_cast<std::size_t>(j)).flow > params_.limit ? 1 : 0;
    }
    return std::min(1.0, 0.3 + (all > 0 ? static_cast<double>(suspects) / all : 0));
  }

  /// Is this group's foot nearer than the ground below it? Only of upright groups, below the horizon, whose
  /// foot is in the image; else nothing is said.
  std::optional<double> hanging_sigmas(const std::vector<int>& members) {
    if (!ground_usable_ || members.size() < 4) return std::nullopt;
    values_.clear();
    double lowest_px = -1e9, sx = 0, sy = 0, sxx = 0, sxy = 0;
    int n = 0;
    for (const int m : members) {
      const Point& p = points_[static_cast<std::size_t>(m)];
      const GroundPoint at = ground_point(p);
      const double below = ground_->below(at.x, at.y);
      lowest_px = std::max(lowest_px, p.pair.y);
      if (!(below > 0.04 * cells_.height_px)) continue;
      values_.push_back(at.inverse_depth / below);
      if (!(at.inverse_depth > 0)) continue;
      const double x = std::log(below), y = std::log(at.inverse_depth);
      sx += x, sy += y, sxx += x * x, sxy += x * y, ++n;
    }
    const auto size = static_cast<double>(members.size()), count = static_cast<double>(n);
    if (static_cast<double>(values_.size()) < 0.7 * size || n < 3) return std::nullopt;
    if (lowest_px > (0.5 - 0.03) * cells_.height_px) return std::nullopt;
    const double spread = sxx - sx * sx / count;
    if (!(spread > 0.01 * count)) return std::nullopt;
    if ((sxy - sx * sy / count) / spread > 0.5) return std::nullopt;  // lies like the ground does: slope 1
    return sigmas_above_ground();
  }

  /// From the ratios in values_: the foot is their 10 % quantile; few points show it badly.
  double sigmas_above_ground() {
    const auto count = static_cast<double>(values_.size());
    const auto foot = values_.begin() + static_cast<std::ptrdiff_t>(values_.size() / 10);
    std::nth_element(values_.begin(), foot, values_.end());
    const double ratio = *foot / ground_->scale;
    if (!(ratio > 0)) return 0;
    const double limit = params_.ground_ratio * (1 + 1 / count);
    return std::clamp(params_.limit + std::log(ratio / limit) / 0.15, 0.0, kMaxSigmas);
  }

  void vote(const Context& context, Votes& votes) const {
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const auto i = static_cast<std::size_t>(points_[k].feature);
      if (!context.judged(i)) continue;
      votes.cast(i, suspicion_[k] > params_.limit ? Vote::Dynamic : Vote::Static,
                 suspicion(suspicion_[k], params_.limit));
    }
  }

  Params params_;
  FeatureTracks tracks_;
  BackgroundMotionEstimator estimator_;
  FlowGroups groups_;
  GroundPlaneFinder ground_finder_;
  std::optional<ViewMotion> motion_;
  std::optional<GroundPlane> ground_;
  bool ground_usable_ = false;
  int last_gap_ = 1;

  cv::Size2d extent_;
  ImageCells cells_;
  cv::Point2d centre_, focus_;
  double focal_px_ = 1, y_scale_ = 1, gap_weight_ = 1;
  std::vector<Evidence> evidence_, last_evidence_;
  std::vector<Point> points_;
  std::vector<ViewPair> pairs_;
  std::vector<ImageNeighbours::Point> places_;
  std::vector<GroundPoint> ground_points_;
  std::vector<int> seeds_, counts_;
  std::vector<double> suspicion_, values_, along_;
};

}  // namespace dynfilter
