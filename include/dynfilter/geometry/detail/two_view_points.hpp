// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::detail {

// Squared residuals of packs of matches in normalised coordinates.
// Both kinds can be compared with one threshold.
// A match passes both with equal probability if its noise is Gaussian and equal in both images.

/// Squared Sampson distance. One degree of freedom, with the variance of the noise.
struct FundamentalError {
  explicit FundamentalError(const Eigen::Matrix3d& F) {
    for (int i = 0; i < 9; ++i) f[i] = static_cast<float>(F(i / 3, i % 3));
  }
  Pack operator()(const Pack& x, const Pack& y, const Pack& u, const Pack& v) const {
    const EpipolarTerms<Pack> terms(f, x, y, u, v);
    return terms.residual * terms.residual / (terms.gradient2() + 1e-30F);
  }
  float f[9];
};

/// Ratio of the 95 % quantiles of chi-square with two and one degrees of freedom, times two images' noise.
constexpr double kTransferScale = 2 * 5.991 / 3.841;

/// Squared transfer distance divided by kTransferScale.
struct HomographyError {
  explicit HomographyError(const Eigen::Matrix3d& H) {
    for (int i = 0; i < 9; ++i) h[i] = static_cast<float>(H(i / 3, i % 3));
  }
  Pack operator()(const Pack& x, const Pack& y, const Pack& u, const Pack& v) const {
    const Pack w = 1.0F / (h[6] * x + h[7] * y + h[8]);
    const Pack a = (h[0] * x + h[1] * y + h[2]) * w - u, b = (h[3] * x + h[4] * y + h[5]) * w - v;
    return (a * a + b * b) * static_cast<float>(1 / kTransferScale);
  }
  float h[9];
};

/// Matches of the seeds as structure of arrays, in spread order, so that a prefix is a fair sample. Both
/// images are centred at their centroids and divided by one common scale (Hartley 1997). Padded to whole
/// packs by repeating matches. This does not change the ranking of hypotheses. Counts are exact.
class TwoViewPoints {
 public:
  std::size_t count() const { return count_; }
  double scale() const { return scale_; }  ///< normalised units per pixel
  /// Standard deviation of the seeds across their longest direction.
  double minor_axis_px() const { return minor_px_; }
  /// Packs of the coordinates from match i. i is a multiple of the pack width.
  Pack x(std::size_t i) const { return at(x_, i); }
  Pack y(std::size_t i) const { return at(y_, i); }
  Pack u(std::size_t i) const { return at(u_, i); }
  Pack v(std::size_t i) const { return at(v_, i); }
  Eigen::Vector2d reference(std::size_t i) const { return {x_[i], y_[i]}; }
  Eigen::Vector2d current(std::size_t i) const { return {u_[i], v_[i]}; }

  void pack(Span<const cv::Point2f> reference, Span<const cv::Point2f> current, Span<const int> seeds) {
    usable_.clear();
    const int n = static_cast<int>(std::min(reference.size(), current.size()));
    for (int seed : seeds) {
      const auto i = static_cast<std::size_t>(seed);
      if (seed >= 0 && seed < n && finite(reference[i]) && finite(current[i])) usable_.push_back(seed);
    }
    count_ = usable_.size();
    if (count_ == 0) return;
    order_.clear();
    visit_spread(count_, [&](std::size_t i) { order_.push_back(usable_[i]); });
    measure(reference, current);
    fill(reference, current);
    fill_cells();
  }

  /// Transforms from pixels to normalised coordinates.
  Eigen::Matrix3d T1() const { return normaliser(center1_); }
  Eigen::Matrix3d T2() const { return normaliser(center2_); }

  /// Sum of min(e2, tau2) / tau2 over the matches (MSAC, Torr and Zisserman 2000). Returns infinity as soon
  /// as the sum must exceed `best`, either for certain or by three standard deviations of a prefix estimate.
  template <class Error>
  double cost(const Error& error, double tau2, double best) const {
    constexpr std::size_t kBlock = 64;
    const float limit = static_cast<float>(tau2);
    const double share = best / static_cast<double>(padded());
    double total = 0;
    for (std::size_t i = 0; i < padded();) {
      const std::size_t end = std::min(padded(), i + kBlock);
      Pack sum = 0;
      for (; i < end; i += kWidth) sum += min(error(at(x_, i), at(y_, i), at(u_, i), at(v_, i)), limit);
      total += sum.sum() / limit;
      const double seen = static_cast<double>(i);
      if (total > best || total > share * seen + 1.5 * std::sqrt(seen)) {
        return std::numeric_limits<double>::infinity();
      }
    }
    return total;
  }

  /// Calls visit(index, squared error) for every match.
  template <class Error, class Visit>
  void visit(const Error& error, Visit visit) const {
    for (std::size_t i = 0; i < padded(); i += kWidth) {
      const Pack e = error(at(x_, i), at(y_, i), at(u_, i), at(v_, i));
      for (std::size_t k = 0; k < kWidth && i + k < count_; ++k) visit(i + k, e[static_cast<int>(k)]);
    }
  }

  template <class Error>
  int inliers(const Error& error, double tau2) const {
    const auto limit = static_cast<float>(tau2);
    Pack sum = 0;
    std::size_t i = 0;
    for (; i + kWidth <= count_; i += kWidth)
      sum += not_above(error(at(x_, i), at(y_, i), at(u_, i), at(v_, i)), limit);
    int n = static_cast<int>(sum.sum());
    if (i == count_) return n;
    const Pack last = error(at(x_, i), at(y_, i), at(u_, i), at(v_, i));
    for (std::size_t k = 0; i + k < count_; ++k) n += last[static_cast<int>(k)] <= limit ? 1 : 0;
    return n;
  }

  /// Draws `size` distinct matches.
  /// With `spread`, they are from different cells of a 4x4 grid if enough cells are occupied.
  void sample(SampleGenerator& rng, bool spread, int size, std::uint32_t* out) const {
    if (!spread || used_cells_ < size) {
      sample_distinct(rng, static_cast<std::uint32_t>(count_), out, size);
      return;
    }
    std::uint32_t cells[kCells];
    sample_distinct(rng, static_cast<std::uint32_t>(used_cells_), cells, size);
    for (int i = 0; i < size; ++i) {
      const Span<const std::int32_t> members = cells_[used_[cells[i]]];
      out[i] = static_cast<std::uint32_t>(members[rng.below(static_cast<std::uint32_t>(members.size()))]);
    }
  }

 private:
  static constexpr std::size_t kWidth = Pack::kWidth;
  static constexpr int kSide = 4, kCells = kSide * kSide;

  static bool finite(cv::Point2f p) { return std::isfinite(p.x) && std::isfinite(p.y); }
  static Pack at(const std::vector<float>& v, std::size_t i) { return Pack::load(v.data() + i); }
  std::size_t padded() const { return x_.size(); }

  Eigen::Matrix3d normaliser(const Eigen::Vector2d& center) const {
    return rows({scale_, 0, -scale_ * center.x(), 0, scale_, -scale_ * center.y(), 0, 0, 1});
  }

  void measure(Span<const cv::Point2f> reference, Span<const cv::Point2f> current) {
    const double n = static_cast<double>(count_);
    center1_.setZero(), center2_.setZero();
    for (int match : order_) {
      const auto i = static_cast<std::size_t>(match);
      center1_ += Eigen::Vector2d(reference[i].x, reference[i].y);
      center2_ += Eigen::Vector2d(current[i].x, current[i].y);
    }
    center1_ /= n, center2_ /= n;
    double xx = 0, xy = 0, yy = 0, second = 0;
    for (int match : order_) {
      const auto i = static_cast<std::size_t>(match);
      const double dx = reference[i].x - center1_.x(), dy = reference[i].y - center1_.y();
      xx += dx * dx, xy += dx * dy, yy += dy * dy;
      const Eigen::Vector2d d = Eigen::Vector2d(current[i].x, current[i].y) - center2_;
      second += d.squaredNorm();
    }
    minor_px_ = std::sqrt(std::max(0.0, (xx + yy - portable::hypot(xx - yy, 2 * xy)) / (2 * n)));
    const double rms = std::sqrt((xx + yy + second) / (2 * n));
    scale_ = rms > 0 ? std::sqrt(2.0) / rms : 1;
  }

  void fill(Span<const cv::Point2f> reference, Span<const cv::Point2f> current) {
    const std::size_t size = (count_ + kWidth - 1) / kWidth * kWidth;
    for (std::vector<float>* v : {&x_, &y_, &u_, &v_}) v->resize(size);
    for (std::size_t k = 0; k < size; ++k) {
      const auto i = static_cast<std::size_t>(order_[k % count_]);
      x_[k] = static_cast<float>((reference[i].x - center1_.x()) * scale_);
      y_[k] = static_cast<float>((reference[i].y - center1_.y()) * scale_);
      u_[k] = static_cast<float>((current[i].x - center2_.x()) * scale_);
      v_[k] = static_cast<float>((current[i].y - center2_.y()) * scale_);
    }
  }

  void fill_cells() {
    const auto index = [](float a) {
      return static_cast<CellLists::Key>(cell_along((a + 1.8F) / 0.9F, kSide));
    };
    cells_.build(kCells, count_, [&](std::size_t k) {
      return index(y_[k]) * static_cast<CellLists::Key>(kSide) + index(x_[k]);
    });
    used_cells_ = 0;
    for (std::size_t c = 0; c < kCells; ++c)
      if (!cells_[c].empty()) used_[used_cells_++] = c;
  }

  std::size_t count_ = 0;
  int used_cells_ = 0;
  double scale_ = 1, minor_px_ = 0;
  Eigen::Vector2d center1_, center2_;
  std::vector<float> x_, y_, u_, v_;
  std::vector<int> usable_, order_;
  CellLists cells_;
  std::size_t used_[kCells] = {};  ///< cells with matches
};

}  // namespace dynfilter::detail
