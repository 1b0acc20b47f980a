// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/flow_consistency.hpp>

#include <algorithm>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <limits>
#include <tuple>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<FlowConsistencyParams>& FlowConsistencyParams::fields() {
  using P = FlowConsistencyParams;
  static const FieldTable<P> table{
      real("max_gap_s", &P::max_gap_s, "s", {0, 100},
           "longest time over which flow is measured; less while most tracks are younger"),
      flag("ground", &P::ground,
           "groups that do not stand on the ground are dynamic; used only while the camera drives forward"),
  };
  return table;
}

DYNFILTER_INLINE FlowConsistencyFilter::FlowConsistencyFilter(Params params) : params_(params) {
  check_parameters(params_, kName);
  ViewMotionOptions options;
  options.max_distance_px = Params::kMaxDistance_px;
  estimator_ = ViewMotionEstimator(options);
}

DYNFILTER_INLINE void FlowConsistencyFilter::apply(const Evidence& evidence, Votes& votes) {
  follow(evidence);
  set_view(evidence);
  choose_gaps();
  sort_features();
  for (const int gap : gaps_) {
    if (!needs_gap(gap) || !measure(evidence, gap, votes)) continue;
    group();
    weigh_flows();
    weigh_groups();
    if (gap == ground_gap_) weigh_ground();
    if (gap < ground_gap_ && gap == gaps_.back()) infer_ground_distances();
  }
  vote(evidence, votes);
}

DYNFILTER_INLINE void FlowConsistencyFilter::reset() {
  evidence_.clear();
  ages_s_.clear();
  motion_.reset();
  main_motion_.reset();
  ahead_.reset();
  ground_.reset();
  steps_.clear();
  prior_watch_.reset();
  extent_ = {};
}

inline ViewMotion FlowConsistencyFilter::TimedMotion::over(double other_s) const {
  ViewMotion scaled = motion;
  for (double& w : scaled.rotation_rad) w *= other_s / gap_s;
  return scaled;
}

inline void FlowConsistencyFilter::follow(const Evidence& evidence) {
  const Match& match = evidence.match({false, 1});
  tracks_ = &evidence.tracks({Params::kGapFrames});
  passed_s_ = match.reference ? evidence.frame().timestamp_s - match.reference->timestamp_s : 0;
  if (!(passed_s_ > 0)) passed_s_ = kUnknown_s;
  for (double& age_s : ages_s_) age_s += passed_s_;
  ages_s_.insert(ages_s_.begin(), 0);
  ages_s_.resize(std::min(ages_s_.size(), static_cast<std::size_t>(Params::kGapFrames) + 1));
  take_over_evidence();
  take_over_turns(evidence, match);
  main_motion_.pass(passed_s_);
  ahead_.pass(passed_s_);
  ground_.pass(passed_s_);
}

inline void FlowConsistencyFilter::take_over_evidence() {
  std::swap(evidence_, last_evidence_);
  const std::size_t n = tracks_->size();
  evidence_.assign(n, TrackEvidence());
  for (std::size_t i = 0; i < n; ++i) {
    const int previous = tracks_->previous(i);
    if (previous >= 0 && static_cast<std::size_t>(previous) < last_evidence_.size())
      evidence_[i] = last_evidence_[static_cast<std::size_t>(previous)];
    evidence_[i].flow.pass(passed_s_);
    evidence_[i].off_ground.pass(passed_s_);
  }
  judged_.assign(n, false);
  suspicion_.assign(n, 0);
}

inline void FlowConsistencyFilter::take_over_turns(const Evidence& evidence, const Match& match) {
  steps_.insert(steps_.begin(), evidence.motion_prior(match));
  steps_.resize(ages_s_.size() - 1);
}

inline std::optional<ViewTurn> FlowConsistencyFilter::turn_over(int gap) const {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // R_current_reference
  double sigma_rad = 0;                             // a bias is the same in every step, so deviations add up
  for (std::size_t k = 0; k < static_cast<std::size_t>(gap); ++k) {
    if (k >= steps_.size() || !steps_[k]) return std::nullopt;
    R = R * steps_[k]->T_current_reference.R();
    sigma_rad += std::sqrt(steps_[k]->covariance_matrix().bottomRightCorner<3, 3>().trace() / 3);
  }
  const Eigen::Vector3d back = rotation_vector(R.transpose());
  return ViewTurn{{back.x(), back.y(), back.z()}, sigma_rad};
}

inline void FlowConsistencyFilter::choose_gaps() {
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

inline bool FlowConsistencyFilter::needs_gap(int gap) const {
  if (gap == gaps_.front() || gap == ground_gap_) return true;
  for (std::size_t i = 0; i < tracks_->size(); ++i)
    if (!judged_[i] && tracks_->length(i) >= gap) return true;
  return false;
}

inline bool FlowConsistencyFilter::measure(const Evidence& evidence, int gap, Votes& votes) {
  gap_s_ = gap_s(gap);
  collect_points(evidence, gap);
  seeds_.clear();
  pairs_.clear();
  for (std::size_t k = 0; k < points_.size(); ++k) {
    pairs_.push_back(points_[k].pair);
    if (points_[k].seed) seeds_.push_back(static_cast<int>(k));
  }
  const bool main = gap == gaps_.front();
  if (main) motion_ = main_motion_.value();
  std::optional<ViewMotion> guess;
  if (motion_) guess = motion_->over(gap_s_);
  const std::optional<ViewTurn> turn = turn_over(gap);
  const std::optional<ViewMotion> found = estimator_.estimate(pairs_, seeds_, cells_, focal_px_, guess, !main,
                                                              prior_watch_.trusts() ? turn : std::nullopt);
  if (main && found && turn)
    prior_watch_.observe(ViewMotionEstimator::turn_distance2(*turn, *found, Params::kMaxDistance_px),
                         passed_s_);
  if (main && turn && !prior_watch_.trusts()) votes.note("the motion prior contradicts the images: ignored");
  if (main) {
    main_motion_.reset();
    if (found) main_motion_.confirm({*found, gap_s_});
    note(gap, found, votes);
  }
  if (!found) return false;
  motion_ = TimedMotion{*found, gap_s_};
  const ViewFlowModel model(*found);
  for (Point& p : points_) {
    p.flow = model(p.pair);
    p.length_px = p.flow.length_px();
    set_noise(p);
  }
  const auto silent = [](const Point& p) { return p.across_noise > kMostNoise; };
  points_.erase(std::remove_if(points_.begin(), points_.end(), silent), points_.end());
  noise_px_ = measured_noise_px();
  return true;
}

inline void FlowConsistencyFilter::set_noise(Point& p) const {
  const MatchSpread spread = tracks_->spread(static_cast<std::size_t>(p.feature));
  if (!spread.slides()) return;
  constexpr double kTurn2 = MatchSpread::kEdgeTurn_rad * MatchSpread::kEdgeTurn_rad;
  const double on_line = spread.edge.x * p.flow.line_x + spread.edge.y * p.flow.line_y;
  const double across2 = spread.across, more2 = spread.along - across2, share = on_line * on_line;
  p.along_noise = std::sqrt(across2 + more2 * share);
  p.across_noise = std::sqrt(across2 + more2 * (std::max(0.0, 1 - share) + kTurn2));
}

inline void FlowConsistencyFilter::note(int gap, const std::optional<ViewMotion>& found, Votes& votes) const {
  if (!found) return votes.note("model: none, ", seeds_.size(), " seeds with a track");
  votes.note("model: ", found->has_baseline() ? "rotation and direction" : "rotation", " over ", gap,
             " frames, ", points_.size(), " features");
}

inline void FlowConsistencyFilter::set_view(const Evidence& evidence) {
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
  focal_px_ = Params::kFocalOfWidth * cells_.width_px;
  y_scale_ = 1;
  if (!frame.camera || !frame.camera->valid()) return;
  centre_ = {frame.camera->cx_px, frame.camera->cy_px};
  focal_px_ = frame.camera->fx_px;
  y_scale_ = frame.camera->fx_px / frame.camera->fy_px;
}

inline void FlowConsistencyFilter::sort_features() {
  order_.clear();
  for (std::size_t i = 0; i < tracks_->size(); ++i)
    if (tracks_->length(i) > 0 && within(tracks_->at(i, 0)))
      order_.push_back({centred(tracks_->at(i, 0)), i});
  std::sort(order_.begin(), order_.end(), [](const PlacedFeature& a, const PlacedFeature& b) {
    return std::tie(a.now.x, a.now.y, a.feature) < std::tie(b.now.x, b.now.y, b.feature);
  });
}

inline void FlowConsistencyFilter::collect_points(const Evidence& evidence, int gap) {
  points_.clear();
  for (const auto& [now, i] : order_) {
    if (tracks_->length(i) < gap || !within(tracks_->at(i, gap))) continue;
    const cv::Point2d then = centred(tracks_->at(i, gap));
    const bool firm = tracks_->spread(i).along < MatchSpread::kSaysNothing, seed = firm && evidence.seed(i);
    points_.push_back({static_cast<int>(i), {then.x, then.y, now.x, now.y}, {}, 0, seed});
  }
  const auto before = [](const Point& p, const Point& q) {
    return std::tie(p.pair.x, p.pair.y, p.pair.reference_x, p.pair.reference_y, p.feature) <
           std::tie(q.pair.x, q.pair.y, q.pair.reference_x, q.pair.reference_y, q.feature);
  };
  // Only features at the same position may still be out of order.
  if (!std::is_sorted(points_.begin(), points_.end(), before))
    std::sort(points_.begin(), points_.end(), before);
}

inline void FlowConsistencyFilter::group() {
  places_.clear();
  for (const Point& p : points_) places_.emplace_back(p.pair.x, p.pair.y);
  groups_.build(places_, kReach * cells_.width_px, kNeighbours, kOnePatch_px,
                [&](std::size_t i, std::size_t j) {
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

inline double FlowConsistencyFilter::measured_noise_px() {
  values_.clear();
  for (const Point& p : points_)
    if (std::abs(p.flow.across_px) < Params::kMaxDistance_px)
      values_.push_back(std::abs(p.flow.across_px) / p.across_noise);
  return values_.empty() ? Params::kNoise_px
                         : std::max(Params::kNoise_px, 1.48 * averaged_median_in_place(values_));
}

inline double FlowConsistencyFilter::middle_inverse_depth() {
  in_cell_.build(static_cast<std::size_t>(cells_.count()), points_.size(), [&](std::size_t k) {
    const Point& p = points_[k];
    const bool agrees = std::abs(p.flow.across_px) < Params::kLimit * noise_px_ &&
                        evidence_of(k).flow.value() < Params::kLimit;
    return agrees ? static_cast<CellLists::Key>(cells_.of(p.pair.x, p.pair.y)) : CellLists::kNoCell;
  });
  values_.clear();
  inverse_depths_.reserve(tracks_->size());  // no allocation later, whichever cell the points gather in
  for (std::size_t c = 0; c < in_cell_.size(); ++c) {
    if (in_cell_[c].empty()) continue;
    inverse_depths_.clear();
    for (const std::int32_t k : in_cell_[c])
      inverse_depths_.push_back(points_[static_cast<std::size_t>(k)].flow.inverse_depth);
    values_.push_back(averaged_median_in_place(inverse_depths_));
  }
  return motion_->motion.has_baseline() && values_.size() >= kLeastCells
             ? std::max(0.0, averaged_median_in_place(values_))
             : std::numeric_limits<double>::infinity();
}

inline double FlowConsistencyFilter::wrong_way_px(const Point& p, double along_px,
                                                  double middle_inverse_depth) const {
  if (!motion_->motion.has_baseline()) return along_px;
  if (along_px < 0 || std::isinf(middle_inverse_depth)) return std::min(0.0, along_px);
  const double middle_px = middle_inverse_depth * line_length(p.flow);
  return std::max(0.0, along_px - kNearest * (middle_px + noise_px_));
}

inline void FlowConsistencyFilter::weigh_flows() {
  const double middle = middle_inverse_depth();
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (judged(k)) continue;
    const Point& own = points_[k];
    values_.assign(1, own.flow.across_px / own.across_noise);
    along_.assign(1, points_[k].flow.along_px);
    for (const int j : groups_.linked(k)) {
      const Point& q = points_[static_cast<std::size_t>(j)];
      values_.push_back(q.flow.across_px / q.across_noise);
      along_.push_back(points_[static_cast<std::size_t>(j)].flow.along_px);
    }
    const double across = averaged_median_in_place(values_);
    const double wrong_way = wrong_way_px(own, averaged_median_in_place(along_), middle) / own.along_noise;
    const double sigma_px = portable::hypot(noise_px_, Params::kNoiseOfFlow * points_[k].length_px);
    evidence_of(k).flow.observe(std::min(portable::hypot(across, wrong_way) / sigma_px, kMaxSigmas),
                                Params::kMemory_s);
  }
}

inline void FlowConsistencyFilter::weigh_groups() {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Span<const int> members = groups_.group(g);
    values_.clear();
    for (const int m : members) values_.push_back(evidence_of(static_cast<std::size_t>(m)).flow.value());
    const double together = averaged_median_in_place(values_);
    for (const int m : members) {
      const auto k = static_cast<std::size_t>(m), i = static_cast<std::size_t>(points_[k].feature);
      if (judged_[i]) continue;
      suspicion_[i] = members.size() >= kGroup ? together : evidence_[i].flow.value() * share_of_suspects(k);
    }
  }
  for (const Point& p : points_) judged_[static_cast<std::size_t>(p.feature)] = true;
}

inline double FlowConsistencyFilter::share_of_suspects(std::size_t k) {
  const Span<const int> near = groups_.near(k);
  const auto suspects = std::count_if(near.begin(), near.end(), [&](int j) {
    return evidence_of(static_cast<std::size_t>(j)).flow.value() > Params::kLimit;
  });
  return near.empty() ? 0 : static_cast<double>(suspects) / static_cast<double>(near.size());
}

inline bool FlowConsistencyFilter::find_focus() {
  const auto& c = motion_->motion.direction;
  if (!motion_->motion.has_baseline() || !(c[2] > kAhead)) return false;
  focus_.x = static_cast<float>(motion_->motion.focal_px * c[0] / c[2]);
  focus_.y = static_cast<float>(motion_->motion.focal_px * c[1] / c[2]);
  return true;
}

inline void FlowConsistencyFilter::weigh_ground() {
  const bool ahead = find_focus();
  ahead_.observe(ahead ? 1 : 0, kDriveMemory_s);
  if (!ahead || !drives()) return;
  grounded_.clear();
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Point& p = points_[k];
    grounded_.push_back({{p.pair.reference_x - focus_.x, p.pair.reference_y - focus_.y, p.flow.inverse_depth,
                          cells_.of(p.pair.x, p.pair.y)},
                         p.pair.x,
                         p.pair.y,
                         line_length(p.flow),
                         evidence_of(k).flow.value() < Params::kLimit});
  }
  const std::vector<std::optional<double>>& sigmas = ground_.compare(
      grounded_, groups_, {gap_s_, cells_.height_px, focus_.y, noise_px_, Params::kLimit, kMaxSigmas});
  for (std::size_t k = 0; k < sigmas.size(); ++k) {
    ExpiringMean& off_ground = evidence_of(k).off_ground;
    if (sigmas[k])
      off_ground.observe(*sigmas[k], Params::kMemory_s);
    else if (off_ground.inferred())
      off_ground.reset();
  }
}

inline void FlowConsistencyFilter::infer_ground_distances() {
  compared_.resize(points_.size());
  for (std::size_t k = 0; k < points_.size(); ++k)
    compared_[k] = tracks_->length(static_cast<std::size_t>(points_[k].feature)) >= ground_gap_;
  for (int step = 0; step < kInferenceSteps; ++step) infer_ground_distances_once();
}

inline void FlowConsistencyFilter::infer_ground_distances_once() {
  inferred_.clear();
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (compared_[k]) continue;
    values_.clear();
    double since_s = 0;
    for (const int j : groups_.linked(k)) {
      if (!compared_[static_cast<std::size_t>(j)]) continue;
      const ExpiringMean& off_ground = evidence_of(static_cast<std::size_t>(j)).off_ground;
      values_.push_back(off_ground.value());
      if (off_ground.known()) since_s = std::max(since_s, off_ground.since_s());
    }
    if (values_.size() < kInferenceNeighbours) continue;
    evidence_of(k).off_ground.infer(averaged_median_in_place(values_), since_s);
    inferred_.push_back(k);
  }
  for (const std::size_t k : inferred_) compared_[k] = true;
}

inline void FlowConsistencyFilter::spread(const Evidence& evidence) {
  const std::size_t n = evidence.size();
  depths_m_.assign(n, std::numeric_limits<float>::quiet_NaN());
  excess_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (judged_[i])
      excess_[i] = static_cast<float>(std::min(
          portable::hypot(suspicion_[i], evidence_[i].off_ground.value()) - Params::kLimit, Params::kLimit));
  neighbours_.build(evidence.pixels(), depths_m_, static_cast<float>(kReach * cells_.width_px));
  neighbours_.lay_out(
      excess_around_, [&](std::size_t i) { return excess_[i]; },
      [&](std::size_t i) { return judged_[i] ? 1.0F : 0.0F; });
}

inline float FlowConsistencyFilter::mean_around(const Evidence& evidence, std::size_t i) const {
  const NeighbourPlaces::Sum sum =
      neighbours_.around(excess_around_, evidence.pixels()[i], depths_m_[i],
                         static_cast<float>(kUntrackedReach * cells_.width_px), 0);
  return sum.values / (sum.weights + kOwnWeight);
}

inline void FlowConsistencyFilter::vote(const Evidence& evidence, Votes& votes) {
  spread(evidence);
  for (std::size_t i = 0; i < judged_.size(); ++i) {
    if (!evidence.judged(i)) continue;
    const double excess = static_cast<double>(judged_[i] ? excess_[i] : mean_around(evidence, i));
    const Vote otherwise = judged_[i] ? Vote::Static : Vote::Unknown;
    votes.cast(i, excess > 0 ? Vote::Dynamic : otherwise,
               suspicion(std::max(0.0, Params::kLimit + excess), Params::kLimit));
  }
}

}  // namespace dynfilter
