// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <string>
#include <vector>

namespace mine {

struct MedianFlowParams {
  double max_difference_px = 8;
  int min_matches = 20;

  static const dynfilter::FieldTable<MedianFlowParams>& fields() {
    using P = MedianFlowParams;
    static const dynfilter::FieldTable<P> table{
        dynfilter::real("max_difference_px", &P::max_difference_px, "px", {0, 1000},
                        "a feature whose flow differs by more from the median flow is dynamic"),
        dynfilter::integer("min_matches", &P::min_matches, "features", {1, 100000},
                           "with fewer correspondences the filter abstains"),
    };
    return table;
  }
};

/// Rejects features whose flow differs from that of most of the image.
/// This is an example, not a useful method.
///
/// Formula:  |flow_i - median flow of the seeds| > max_difference_px, flow since the last frame.
/// Needs:    correspondences.
/// Votes:    Dynamic beyond the limit, else Static.
/// Abstains: without a correspondence, and on all features with fewer than min_matches.
/// Blind to: parallax. If the camera moves sideways, near static objects are rejected.
/// State:    none.
/// Cost:     one median.
class MedianFlowFilter final : public dynfilter::NamedFilter<MedianFlowFilter> {
 public:
  using Params = MedianFlowParams;
  static constexpr const char* kName = "median_flow";
  static constexpr const char* kSummary = "features whose flow differs from the median flow";

  explicit MedianFlowFilter(Params params = Params()) : params_(params) {
    dynfilter::check_parameters(params_, kName);
  }

  dynfilter::Needs needs() const override {
    return {dynfilter::Input::Correspondence, dynfilter::Input::None, 1};
  }

  void apply(const dynfilter::Evidence& evidence, dynfilter::Votes& votes) override {
    const dynfilter::Match& match = evidence.match({});  // with the last frame
    evidence.collect_seeds(match, false, seeds_);
    if (seeds_.size() < static_cast<std::size_t>(params_.min_matches))
      return votes.note("only " + std::to_string(seeds_.size()) + " correspondences");
    const cv::Point2f usual(median(evidence, match, &cv::Point2f::x),
                            median(evidence, match, &cv::Point2f::y));
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      if (!match.found(i)) continue;
      const cv::Point2f off = flow(evidence, match, i) - usual;
      const double distance_px = std::hypot(off.x, off.y);
      votes.cast(i,
                 distance_px > params_.max_difference_px ? dynfilter::Vote::Dynamic : dynfilter::Vote::Static,
                 dynfilter::suspicion(distance_px, params_.max_difference_px));
    }
  }

 private:
  static cv::Point2f flow(const dynfilter::Evidence& evidence, const dynfilter::Match& match, std::size_t i) {
    return evidence.pixels()[i] - match.correspondences.reference_px[i];
  }
  float median(const dynfilter::Evidence& evidence, const dynfilter::Match& match, float cv::Point2f::*axis) {
    values_.clear();
    for (const int i : seeds_) values_.push_back(flow(evidence, match, static_cast<std::size_t>(i)).*axis);
    const auto middle = values_.begin() + static_cast<std::ptrdiff_t>(values_.size() / 2);
    std::nth_element(values_.begin(), middle, values_.end());
    return *middle;
  }

  Params params_;
  std::vector<int> seeds_;
  std::vector<float> values_;
};

}  // namespace mine
