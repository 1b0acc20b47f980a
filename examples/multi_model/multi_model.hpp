// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "sequential_homographies.hpp"

namespace multi_model {

using dynfilter::Evidence;
using dynfilter::FieldTable;
using dynfilter::Input;
using dynfilter::Match;
using dynfilter::NamedFilter;
using dynfilter::Needs;
using dynfilter::suspicion;
using dynfilter::Vote;
using dynfilter::Votes;

struct MultiModelParams {
  double chance = 0.003;
  static constexpr int kMaxModels = 20;    ///< Largest number of homographies.
  static constexpr int kIterations = 500;  ///< RANSAC samples per homography.
  /// A sample is a match and two of this many nearest matches.
  static constexpr int kNeighbours = 8;

  static const FieldTable<MultiModelParams>& fields();
};

/// Rejects mismatches: matches that no surface explains, static or moving.
/// Uses sequential RANSAC with samples of neighbouring matches (Vincent and Laganiere 2001 use it for
/// planes).
///
/// Formula:  Homographies H_1, H_2, ... are fitted in turn to the unexplained matches.
///           The loop ends if wrong matches alone would be expected to support one more.
///           Dynamic if |p1 - H_k p2| > d for every k.
///           A match with a random end agrees within d with probability `chance`.
/// Needs:    correspondences.
/// Abstains: without correspondence, and if no homography has support.
/// Blind to: movers, by design; mismatches that agree with each other (repeated texture).
/// State:    none; the pipeline keeps the last frame.
/// Cost:     about 3 ms for 300 matches, a third of them wrong.
class MultiModelFilter final : public NamedFilter<MultiModelFilter> {
 public:
  using Params = MultiModelParams;
  static constexpr const char* kName = "multi_model";
  static constexpr const char* kSummary = "mismatches: features whose match no homography explains";

  explicit MultiModelFilter(Params params = Params());

  Needs needs() const override { return {Input::Correspondence, Input::Camera, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  struct Entry {
    std::size_t feature;
    ImageMatch match;
  };

  static SequentialHomographiesOptions options(const Params& p);

  /// Sorts by position, so that the result does not depend on the features' order.
  void collect(const Evidence& evidence, const Match& match);

  Params params_;
  SequentialHomographies models_;
  std::vector<Entry> entries_;
  std::vector<ImageMatch> matches_;
};

inline const FieldTable<MultiModelParams>& MultiModelParams::fields() {
  using P = MultiModelParams;
  static const FieldTable<P> table{
      dynfilter::real("chance", &P::chance, "", {1e-6, 0.5},
                      "probability that a wrong match agrees with a homography by chance"),
  };
  return table;
}

inline MultiModelFilter::MultiModelFilter(Params params) : params_(params), models_(options(params)) {
  dynfilter::check_parameters(params_, kName);
}

inline void MultiModelFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  collect(evidence, match);
  matches_.clear();
  for (const Entry& e : entries_) matches_.push_back(e.match);
  models_.fit(matches_);
  const double limit_px = models_.max_distance_px();
  votes.note(models_.models(), " homographies for ", matches_.size(), " matches, within ",
             std::lround(limit_px), " px");
  if (models_.models() == 0) return;
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    const double distance = models_.distance_px(k);
    if (evidence.judged(entries_[k].feature))
      votes.cast(entries_[k].feature, distance > limit_px ? Vote::Dynamic : Vote::Static,
                 std::isfinite(distance) ? suspicion(distance, limit_px) : 1.0F);
  }
}

inline SequentialHomographiesOptions MultiModelFilter::options(const Params& p) {
  SequentialHomographiesOptions o;
  o.chance = p.chance;
  o.max_models = Params::kMaxModels;
  o.iterations = Params::kIterations;
  o.neighbours = Params::kNeighbours;
  return o;
}

inline void MultiModelFilter::collect(const Evidence& evidence, const Match& match) {
  constexpr double kMost = 1e6;
  entries_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!match.found(i)) continue;
    const cv::Point2f &now = evidence.undistorted_pixels()[i], &then = match.reference_undistorted_px[i];
    const ImageMatch m{static_cast<double>(now.x), static_cast<double>(now.y), static_cast<double>(then.x),
                       static_cast<double>(then.y)};
    const double size = std::abs(m.x) + std::abs(m.y) + std::abs(m.rx) + std::abs(m.ry);
    if (size < kMost) entries_.push_back({i, m});  // false for NaN
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    if (a.match.x != b.match.x) return a.match.x < b.match.x;
    if (a.match.y != b.match.y) return a.match.y < b.match.y;
    if (a.match.rx != b.match.rx) return a.match.rx < b.match.rx;
    if (a.match.ry != b.match.ry) return a.match.ry < b.match.ry;
    return a.feature < b.feature;
  });
}

}  // namespace multi_model
