// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace multi_model {

using dynfilter::PointGrid;
using dynfilter::SampleGenerator;
using dynfilter::Span;

/// A match between two images [px].
struct ImageMatch {
  double x = 0, y = 0;    ///< in the current image
  double rx = 0, ry = 0;  ///< in the reference image
};

/// Options of SequentialHomographies.
struct SequentialHomographiesOptions {
  double chance = 0.003;  ///< probability that a wrong match agrees with a homography by chance
  int max_models = 20;
  int iterations = 500;  ///< samples per model
  int neighbours = 8;    ///< a sample is a match and two of this many nearest matches
};

/// Fits homographies to matches one after another.
/// RANSAC fits each one to the matches that the earlier ones do not explain.
/// Each homography explains a part of a surface, static or moving.
/// A sample is three neighbouring matches, which define an affinity.
/// The affinity is extended and refined by least squares.
/// A match without a homography of sufficient support is a mismatch.
///
/// Both thresholds are a contrario (Desolneux, Moisan, Morel 2000).
/// A wrong match ends anywhere in the reference image of area A.
/// It agrees within d with probability pi d^2 / A, so `chance` sets d.
/// The support of a homography must be expected less than once among all samples of wrong matches.
///
/// Cost: about 0.8 ms per model for 300 matches, growing with their number.
/// Deterministic; sort the matches by position to be independent of their order.
class SequentialHomographies {
 public:
  using Options = SequentialHomographiesOptions;

  explicit SequentialHomographies(const Options& options = Options()) : options_(options) {}

  /// Model number of each match; -1: none.
  const std::vector<int>& fit(const std::vector<ImageMatch>& matches);

  std::size_t models() const { return models_.size(); }
  /// Largest distance of a match that agrees, in the reference image.
  double max_distance_px() const { return max_distance_px_; }
  /// Distance of match i from its best model [px]. Infinite without a model.
  double distance_px(std::size_t i) const;

 private:
  // Row-major, from current to reference, in pixels relative to centre_.
  using Homography = std::array<double, 9>;

  static constexpr double kPi = 3.14159265358979323846;
  static constexpr int kLeastSupport = 4;
  static constexpr double kTail = 0.025;  ///< share of the positions on either side that is ignored

  /// Area of the box around the positions in the reference image.
  double reference_area_px2();

  /// Smallest support with an expected number of false alarms below one. Every sample of n matches is a test.
  /// Three supporters are the sample itself, and the others agree by chance.
  int support_needed(std::size_t n) const;

  void normalise();
  double squared_distance(const Homography& h, const ImageMatch& m) const;

  /// Within which the matches of a sample are: a quarter of the extent from the middle.
  double neighbourhood_px() const { return 0.25 * scale_px_; }

  bool next_model();
  void try_sample();

  /// Affinity through three matches.
  /// False if they are nearly collinear in either image or change orientation.
  bool affinity(const int (&sample)[3], Homography& h) const;

  void attempt(const Homography& h);

  /// Collects the remaining matches within `factor` times the largest distance.
  void collect_support(const Homography& h, double factor);

  void grow(bool wide);

  /// Algebraic least squares over the support with h[8] = 1.
  /// Runs twice, the second time in units of distance.
  bool least_squares(Homography& h) const;

  Options options_;
  SampleGenerator rng_{0};
  const std::vector<ImageMatch>* matches_ = nullptr;
  double centre_x_ = 0, centre_y_ = 0, scale_px_ = 1, max_distance_px_ = 0, best_score_ = 0;
  Homography best_{};
  std::vector<Homography> models_;
  PointGrid grid_;
  std::vector<cv::Point2d> places_;
  std::vector<int> label_, left_, near_, support_;
  std::vector<double> values_;
};

inline const std::vector<int>& SequentialHomographies::fit(const std::vector<ImageMatch>& matches) {
  matches_ = &matches;
  label_.assign(matches.size(), -1);
  rng_ = SampleGenerator(0x6d6f6465ULL);
  normalise();
  max_distance_px_ = std::sqrt(options_.chance * reference_area_px2() / kPi);
  models_.clear();
  while (static_cast<int>(models_.size()) < options_.max_models) {
    left_.clear();
    for (std::size_t i = 0; i < matches.size(); ++i)
      if (label_[i] < 0) left_.push_back(static_cast<int>(i));
    if (!next_model()) break;
  }
  return label_;
}

inline double SequentialHomographies::distance_px(std::size_t i) const {
  double best = HUGE_VAL;
  for (const Homography& h : models_) best = std::min(best, squared_distance(h, (*matches_)[i]));
  return std::sqrt(best);
}

inline double SequentialHomographies::reference_area_px2() {
  const auto side = [&](double ImageMatch::*member) {
    values_.clear();
    for (const ImageMatch& m : *matches_) values_.push_back(m.*member);
    if (values_.empty()) return 0.0;
    std::sort(values_.begin(), values_.end());
    const auto tail = static_cast<std::size_t>(kTail * static_cast<double>(values_.size()));
    return (values_[values_.size() - 1 - tail] - values_[tail]) / (1 - 2 * kTail);
  };
  return side(&ImageMatch::rx) * side(&ImageMatch::ry);
}

inline int SequentialHomographies::support_needed(std::size_t n) const {
  const double others = static_cast<double>(n) - 3, near = options_.neighbours;
  double log_alarms = dynfilter::portable::log(static_cast<double>(n) * near * (near - 1) / 2);
  int support = 3;
  while (log_alarms >= 0 && support < static_cast<int>(n)) {
    ++support;
    const double k = support - 3;
    log_alarms += dynfilter::portable::log((others - k + 1) / k * options_.chance);
  }
  return std::max(support, kLeastSupport);
}

inline void SequentialHomographies::normalise() {
  double sx = 0, sy = 0;
  for (const ImageMatch& m : *matches_) sx += m.x + m.rx, sy += m.y + m.ry;
  const double n = 2 * static_cast<double>(std::max<std::size_t>(1, matches_->size()));
  centre_x_ = sx / n, centre_y_ = sy / n;
  double most = 1;
  for (const ImageMatch& m : *matches_)
    most = std::max({most, std::abs(m.x - centre_x_), std::abs(m.y - centre_y_), std::abs(m.rx - centre_x_),
                     std::abs(m.ry - centre_y_)});
  scale_px_ = most;
}

inline double SequentialHomographies::squared_distance(const Homography& h, const ImageMatch& m) const {
  const double x = (m.x - centre_x_) / scale_px_, y = (m.y - centre_y_) / scale_px_;
  const double w = h[6] * x + h[7] * y + h[8];
  if (!(w > 1e-3)) return HUGE_VAL;
  const double dx = (h[0] * x + h[1] * y + h[2]) / w - (m.rx - centre_x_) / scale_px_,
               dy = (h[3] * x + h[4] * y + h[5]) / w - (m.ry - centre_y_) / scale_px_;
  return (dx * dx + dy * dy) * scale_px_ * scale_px_;
}

inline bool SequentialHomographies::next_model() {
  const int needed = support_needed(left_.size());
  if (static_cast<int>(left_.size()) < needed) return false;
  places_.clear();
  for (const int i : left_) {
    const ImageMatch& m = (*matches_)[static_cast<std::size_t>(i)];
    places_.emplace_back(m.x, m.y);
  }
  grid_.build_for_nearest(Span<const cv::Point2d>(places_), static_cast<float>(neighbourhood_px() / 2));
  best_score_ = 0;
  for (int k = 0; k < options_.iterations; ++k) try_sample();
  for (int k = 0; k < 4; ++k) grow(k < 2);
  collect_support(best_, 1);
  if (static_cast<int>(support_.size()) < needed) return false;
  for (const int i : support_) label_[static_cast<std::size_t>(i)] = static_cast<int>(models_.size());
  models_.push_back(best_);
  return true;
}

inline void SequentialHomographies::try_sample() {
  const auto at = rng_.below(static_cast<std::uint32_t>(left_.size()));
  grid_.nearest(places_[at], {options_.neighbours, neighbourhood_px(), 0, static_cast<int>(at)}, near_);
  if (near_.size() < 2) return;
  std::uint32_t pick[2];
  dynfilter::sample_distinct(rng_, static_cast<std::uint32_t>(near_.size()), pick, 2);
  const int sample[3] = {left_[at], left_[static_cast<std::size_t>(near_[pick[0]])],
                         left_[static_cast<std::size_t>(near_[pick[1]])]};
  Homography h;
  if (affinity(sample, h)) attempt(h);
}

inline bool SequentialHomographies::affinity(const int (&sample)[3], Homography& h) const {
  double x[3], y[3], u[3], v[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const ImageMatch& m = (*matches_)[static_cast<std::size_t>(sample[k])];
    x[k] = (m.x - centre_x_) / scale_px_, y[k] = (m.y - centre_y_) / scale_px_;
    u[k] = (m.rx - centre_x_) / scale_px_, v[k] = (m.ry - centre_y_) / scale_px_;
  }
  const auto area = [](const double* a, const double* b) {
    return (a[1] - a[0]) * (b[2] - b[0]) - (a[2] - a[0]) * (b[1] - b[0]);
  };
  const double now = area(x, y), then = area(u, v);
  if (!(std::abs(now) > 1e-5 && std::abs(then) > 1e-5 && now * then > 0)) return false;
  const auto row = [&](const double* target, double* out) {
    const double d1 = target[1] - target[0], d2 = target[2] - target[0];
    out[0] = (d1 * (y[2] - y[0]) - d2 * (y[1] - y[0])) / now;
    out[1] = (d2 * (x[1] - x[0]) - d1 * (x[2] - x[0])) / now;
    out[2] = target[0] - out[0] * x[0] - out[1] * y[0];
  };
  row(u, h.data());
  row(v, h.data() + 3);
  h[6] = h[7] = 0, h[8] = 1;
  return true;
}

inline void SequentialHomographies::attempt(const Homography& h) {
  const double limit = max_distance_px_ * max_distance_px_;
  double score = 0;
  for (const int i : left_) {
    const double d = squared_distance(h, (*matches_)[static_cast<std::size_t>(i)]);
    if (d < limit) score += 1 - d / limit;
  }
  if (!(score > best_score_)) return;
  best_score_ = score;
  best_ = h;
}

inline void SequentialHomographies::collect_support(const Homography& h, double factor) {
  const double limit = factor * factor * max_distance_px_ * max_distance_px_;
  support_.clear();
  if (!(best_score_ > 0)) return;
  for (const int i : left_)
    if (squared_distance(h, (*matches_)[static_cast<std::size_t>(i)]) < limit) support_.push_back(i);
}

inline void SequentialHomographies::grow(bool wide) {
  collect_support(best_, wide ? 1.5 : 1);
  Homography h;
  if (support_.size() >= 8 && least_squares(h)) attempt(h);
}

inline bool SequentialHomographies::least_squares(Homography& h) const {
  h = best_;
  for (int round = 0; round < 2; ++round) {
    double A[64] = {}, b[8] = {};
    for (const int i : support_) {
      const ImageMatch& m = (*matches_)[static_cast<std::size_t>(i)];
      const double x = (m.x - centre_x_) / scale_px_, y = (m.y - centre_y_) / scale_px_,
                   u = (m.rx - centre_x_) / scale_px_, v = (m.ry - centre_y_) / scale_px_;
      const double w = h[6] * x + h[7] * y + h[8];
      if (!(w > 1e-3)) continue;
      const double rows[2][8] = {{x, y, 1, 0, 0, 0, -u * x, -u * y}, {0, 0, 0, x, y, 1, -v * x, -v * y}};
      const double target[2] = {u, v};
      for (int r = 0; r < 2; ++r)
        for (int p = 0; p < 8; ++p) {
          b[p] += rows[r][p] * target[r] / (w * w);
          for (int q = 0; q < 8; ++q) A[p * 8 + q] += rows[r][p] * rows[r][q] / (w * w);
        }
    }
    // A weak prior against perspective, which a small patch cannot separate from noise.
    const double weak = 1e-3 * static_cast<double>(support_.size());
    A[6 * 8 + 6] += weak, A[7 * 8 + 7] += weak;
    if (!dynfilter::detail::solve_positive_definite(A, b, 8)) return false;
    std::copy(b, b + 8, h.begin());
    h[8] = 1;
  }
  return true;
}

}  // namespace multi_model
