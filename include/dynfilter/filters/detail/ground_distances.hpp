// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/filters/detail/flow_evidence.hpp>
#include <dynfilter/motion/expiring.hpp>
#include <dynfilter/motion/ground_contact.hpp>
#include <optional>
#include <vector>

namespace dynfilter::detail {

/// How far groups of features are from standing on the ground. Only a camera that drives forward has its
/// horizon in the image and ground below it.
class GroundDistances {
 public:
  void reset() {
    ahead_.reset();
    ground_.reset();
  }
  void pass(double passed_s) {
    ahead_.pass(passed_s);
    ground_.pass(passed_s);
  }
  /// Over the gap for the ground.
  void weigh(const GapFlow& flow, const ViewMotion& motion, double gap_s, const FlowView& view,
             FlowEvidence& evidence) {
    const std::optional<cv::Point2d> focus = focus_of(motion);
    ahead_.observe(focus ? 1 : 0, kDriveMemory_s);
    if (!focus || ahead_.value() < kDrives) return;
    grounded_.clear();
    for (std::size_t k = 0; k < flow.size(); ++k) {
      const FlowPoint& p = flow[k];
      const GroundPoint at{p.pair.reference_x - focus->x, p.pair.reference_y - focus->y, p.flow.inverse_depth,
                           view.cells().of(p.pair.x, p.pair.y)};
      grounded_.push_back(
          {at, p.pair.x, p.pair.y, p.line_length(), evidence[p.feature].flow.value() < FlowEvidence::kLimit});
    }
    const std::vector<std::optional<double>>& sigmas = ground_.compare(
        grounded_, flow.groups(),
        {gap_s, view.height_px(), focus->y, flow.noise_px(), FlowEvidence::kLimit, FlowEvidence::kMaxSigmas});
    for (std::size_t k = 0; k < sigmas.size(); ++k) {
      ExpiringMean& off_ground = evidence[flow[k].feature].off_ground;
      if (sigmas[k])
        off_ground.observe(*sigmas[k], FlowEvidence::kMemory_s);
      else if (off_ground.inferred())
        off_ground.reset();
    }
  }
  /// Tracks too young to be compared with the ground take over what similar neighbours have.
  void infer(const GapFlow& flow, const FeatureTracks& tracks, int ground_gap, FlowEvidence& evidence) {
    compared_.resize(flow.size());
    for (std::size_t k = 0; k < flow.size(); ++k) compared_[k] = tracks.length(flow[k].feature) >= ground_gap;
    for (int step = 0; step < kInferenceSteps; ++step) infer_once(flow, evidence);
  }

 private:
  static constexpr double kAhead = 0.97;  ///< cosine: moves within 14 degrees of the optical axis
  /// The camera drives if four fifths of its recent motion were ahead. A hand moves ahead, too, but seldom
  /// for so long: with this time constant, the share is reached after 0.4 s.
  static constexpr double kDrives = 0.8, kDriveMemory_s = 0.25;
  static constexpr int kInferenceSteps = 3;
  static constexpr std::size_t kInferenceNeighbours = 2;

  static std::optional<cv::Point2d> focus_of(const ViewMotion& motion) {
    const auto& c = motion.direction;
    if (!motion.has_baseline() || !(c[2] > kAhead)) return std::nullopt;
    return cv::Point2d(static_cast<float>(motion.focal_px * c[0] / c[2]),
                       static_cast<float>(motion.focal_px * c[1] / c[2]));
  }
  void infer_once(const GapFlow& flow, FlowEvidence& evidence) {
    inferred_.clear();
    for (std::size_t k = 0; k < flow.size(); ++k) {
      if (compared_[k]) continue;
      values_.clear();
      double since_s = 0;
      for (const int j : flow.groups().linked(k)) {
        if (!compared_[static_cast<std::size_t>(j)]) continue;
        const ExpiringMean& off_ground = evidence[flow[static_cast<std::size_t>(j)].feature].off_ground;
        values_.push_back(off_ground.value());
        if (off_ground.known()) since_s = std::max(since_s, off_ground.since_s());
      }
      if (values_.size() < kInferenceNeighbours) continue;
      evidence[flow[k].feature].off_ground.infer(averaged_median_in_place(values_), since_s);
      inferred_.push_back(k);
    }
    for (const std::size_t k : inferred_) compared_[k] = true;
  }

  ExpiringMean ahead_;  ///< share of the recent frames in which the camera moved ahead
  GroundContact ground_;
  std::vector<GroundedPoint> grounded_;
  std::vector<bool> compared_;
  std::vector<std::size_t> inferred_;
  std::vector<double> values_;
};

}  // namespace dynfilter::detail
