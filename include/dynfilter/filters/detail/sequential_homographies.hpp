// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <dynfilter/geometry/image_neighbours.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <vector>

namespace dynfilter {

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

  /// Smallest support with an expected number of false alarms below one.
  /// Every sample of n matches is a test.
  /// Three supporters are the sample itself, and the others agree by chance.
  int support_needed(std::size_t n) const;

  void normalise();

  double squared_distance(const Homography& h, const ImageMatch& m) const;

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
  ImageNeighbours grid_;
  std::vector<ImageNeighbours::Point> places_;
  std::vector<int> label_, left_, near_, support_;
  std::vector<double> values_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/sequential_homographies-inl.hpp>
#endif
