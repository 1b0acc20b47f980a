// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/multi_model.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<MultiModelParams>& MultiModelParams::fields() {
  using P = MultiModelParams;
  static const FieldTable<P> table{
      real("chance", &P::chance, "", {1e-6, 0.5},
           "probability that a wrong match agrees with a homography by chance"),
      integer("max_models", &P::max_models, "homographies", {1, 1000}, "largest number of homographies"),
      integer("iterations", &P::iterations, "samples", {1, 1000000}, "RANSAC samples per homography"),
      integer("neighbours", &P::neighbours, "matches", {2, 1000},
              "a sample is a match and two of this many nearest matches"),
      flag("keyframe", &P::keyframe, "compare with the last keyframe instead of gap_frames back"),
      integer("gap_frames", &P::gap_frames, "frames", {1, 30}, "number of frames back"),
  };
  return table;
}

DYNFILTER_INLINE MultiModelFilter::MultiModelFilter(Params params)
    : params_(params), models_(options(params)) {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void MultiModelFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({params_.keyframe, params_.gap_frames});
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
  o.max_models = p.max_models;
  o.iterations = p.iterations;
  o.neighbours = p.neighbours;
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

}  // namespace dynfilter
