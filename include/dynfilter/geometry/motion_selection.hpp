// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/span.hpp>
#include <vector>

namespace dynfilter {

/// Which of several motions are needed to explain the points, and how large the noise is: the shortest
/// description (Rissanen, Automatica 1978).
///
/// The cost of a set H of motions at a noise of s pixels, in nats:
///   sum_k w_k (min_h L(e_hk^2 / s^2 + d_hk^2) + 2 log s) + sum_h price_h + (log(s / s0) / spread)^2 / 2 * n0
/// with L(c) = (nu + 2) / 2 log(1 + c / nu), a Student t density in the image, cut off where a point is an
/// outlier that may be anywhere within `kReach_px`; e the miss in the image [px]; d the miss in depth, in its
/// own standard deviations. w_k is the share of an independent point that a point counts as: the errors of real
/// matches are correlated over tens of pixels.
/// A second motion therefore has to save more than its six parameters cost, and a noise that is larger than
/// predicted is cheaper than many motions that each fit a part of it.
///
/// Greedy with pruning, for each of five noise levels. Cost O(motions * points * selected), about 0.1 ms for
/// 8 motions and 350 points. Owns its scratch.
class MotionSelection {
 public:
  /// Squared misses of every motion at every point, row by row; weights per point; prices per motion [nats].
  struct Input {
    std::size_t motions = 0, points = 0;
    Span<const float> image2_px2, depth2;
    Span<const float> weights;
    Span<const float> prices;
    double noise_px = 0.3;  ///< what is predicted, per axis
  };

  /// Indices of the motions, best first. Empty only without motions or points.
  const std::vector<std::size_t>& select(const Input& input) {
    in_ = &input;
    best_.clear();
    double least = 0;
    for (const double factor : kNoiseFactors) {
      const double noise_px = factor * input.noise_px;
      measure(noise_px);
      grow();
      while (selected_.size() > 1 && prune()) {
      }
      const double cost = total_cost(noise_px, std::log(factor));
      if (!best_.empty() && !(cost < least)) continue;
      least = cost;
      best_ = selected_;
      noise_px_ = noise_px;
    }
    in_ = nullptr;
    return best_;
  }
  /// The noise at which the description was shortest [px per axis].
  double noise_px() const { return noise_px_; }

 private:
  static constexpr float kNu = 3;         ///< degrees of freedom: tails of real matches, as fitted
  static constexpr float kReach_px = 10;  ///< an outlier is found within this
  static constexpr double kNoiseFactors[] = {0.63, 1.0, 1.6, 2.5, 4.0};  ///< of the predicted noise
  static constexpr double kNoiseSpread = 0.5;      ///< standard deviation of log(noise / predicted) ...
  static constexpr double kPredictionWeight = 30;  ///< ... which counts as so many points

  /// log(1 + x) for x >= 0, to 3e-4: a polynomial in the mantissa. The
  /// standard library's costs ten times as much.
  static float log1p_of(float x) {
    const float y = 1 + x;
    std::uint32_t bits = 0;
    std::memcpy(&bits, &y, sizeof bits);
    const auto exponent = static_cast<float>(static_cast<std::int32_t>(bits >> 23) - 127);
    bits = (bits & 0x007FFFFFU) | 0x3F800000U;
    float m = 1;
    std::memcpy(&m, &bits, sizeof m);
    // log2(m) on [1, 2]: least-squares polynomial of degree 4 with exact ends.
    const float t = m - 1;
    const float log2m = t * (1.4419F + t * (-0.7096F + t * (0.4148F + t * (-0.1948F + t * 0.0477F))));
    return 0.69314718F * (exponent + log2m);
  }

  void measure(double noise_px) {
    const std::size_t n = in_->motions * in_->points;
    loss_.resize(n);
    const auto per_s2 = static_cast<float>(1 / (noise_px * noise_px));
    constexpr float kHalf = 0.5F * (kNu + 2);
    worst_ = kHalf * log1p_of(kReach_px * kReach_px * per_s2 / kNu);
    const float *image2 = in_->image2_px2.data(), *depth2 = in_->depth2.data();
    for (std::size_t k = 0; k < n; ++k)
      loss_[k] = std::min(worst_, kHalf * log1p_of(std::min(1e12F, image2[k] * per_s2 + depth2[k]) / kNu));
  }

  const float* row(std::size_t h) const { return loss_.data() + h * in_->points; }
  /// What a motion saves beside those that explain the points now.
  float saving(std::size_t h) const {
    float sum = 0;
    const float* loss = row(h);
    for (std::size_t k = 0; k < in_->points; ++k)
      sum += in_->weights[k] * std::max(0.0F, least_loss_[k] - loss[k]);
    return sum - in_->prices[h];
  }
  void explain(std::size_t h) {
    const float* loss = row(h);
    for (std::size_t k = 0; k < in_->points; ++k) least_loss_[k] = std::min(least_loss_[k], loss[k]);
  }
  void grow() {
    selected_.clear();
    least_loss_.assign(in_->points, worst_);
    while (selected_.size() < in_->motions) {
      std::size_t best = 0;
      float most = -1e30F;
      for (std::size_t h = 0; h < in_->motions; ++h)
        if (const float saved = saving(h); saved > most) most = saved, best = h;
      if (!(most > 0) && !selected_.empty()) return;
      selected_.push_back(best);
      explain(best);
    }
  }
  /// Drops the motion that is missed least, if that costs less than its price.
  bool prune() {
    std::size_t worst = selected_.size();
    float least = 0;
    for (std::size_t s = 0; s < selected_.size(); ++s) {
      least_loss_.assign(in_->points, worst_);
      for (std::size_t other = 0; other < selected_.size(); ++other)
        if (other != s) explain(selected_[other]);
      if (const float saved = saving(selected_[s]); saved < least) least = saved, worst = s;
    }
    if (worst == selected_.size()) return false;
    selected_.erase(selected_.begin() + static_cast<std::ptrdiff_t>(worst));
    return true;
  }
  double total_cost(double noise_px, double log_factor) {
    least_loss_.assign(in_->points, worst_);
    double cost = kPredictionWeight * log_factor * log_factor / (2 * kNoiseSpread * kNoiseSpread);
    for (const std::size_t h : selected_) {
      explain(h);
      cost += static_cast<double>(in_->prices[h]);
    }
    double weights = 0;
    for (std::size_t k = 0; k < in_->points; ++k) {
      cost += static_cast<double>(in_->weights[k] * least_loss_[k]);
      weights += static_cast<double>(in_->weights[k]);
    }
    return cost + 2 * std::log(noise_px) * weights;
  }

  const Input* in_ = nullptr;  ///< during select() only
  std::vector<float> loss_, least_loss_;
  std::vector<std::size_t> selected_, best_;
  float worst_ = 0;
  double noise_px_ = 0;
};

}  // namespace dynfilter
