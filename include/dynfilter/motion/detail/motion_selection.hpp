// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <vector>

namespace dynfilter {

/// Selects the motions that explain the points, and the noise, by the shortest description (Rissanen,
/// Automatica 1978).
///
/// The cost of a set H of motions at a noise of s pixels, in nats:
///   sum_k w_k (min_h L(e_hk^2 / s^2 + d_hk^2) + 2 log s) + sum_h price_h + (log(s / s0) / spread)^2 / 2 * n0
/// L(c) = (nu + 2) / 2 log(1 + c / nu) is a Student t density in the image. It is cut off where a point is an
/// outlier, which may be anywhere within `kReach_px`. e is the residual in the image [px], d the residual in
/// depth in its own standard deviations. w_k is the share of an independent point that point k counts as. The
/// errors of real matches are correlated over tens of pixels. A second motion must save more than its six
/// parameters cost. A noise larger than predicted is cheaper than many motions that each fit a part of it.
///
/// The search is greedy with pruning, at the predicted noise and at its neighbours among five levels, as long
/// as the description gets shorter. Cost: O(motions * points * selected). Owns its scratch.
class MotionSelection {
 public:
  /// Squared residuals of every motion at every point, one row per motion.
  struct Input {
    std::size_t motions = 0, points = 0;
    std::size_t stride = 0;        ///< from row to row, at least `points`
    Span<const float> image2_px2;  ///< not negative
    Span<const float> depth2;      ///< not negative
    Span<const float> weights;     ///< one per point
    Span<const float> prices;      ///< one per motion [nats]
    double noise_px = 0.3;         ///< predicted, per axis
  };

  /// Indices of the selected motions, in the order of selection. Empty only without motions or points.
  const std::vector<std::size_t>& select(const Input& input) {
    in_ = &input;
    best_.clear();
    transpose();
    try_noise(kPredicted);
    for (std::size_t k = kPredicted + 1; k < std::size(kNoiseFactors) && try_noise(k); ++k) {
    }
    for (std::size_t k = kPredicted; k-- > 0 && try_noise(k);) {
    }
    in_ = nullptr;
    return best_;
  }
  /// The noise at which the description is shortest [px per axis].
  double noise_px() const { return noise_px_; }

 private:
  using Four = detail::Float4;
  static constexpr std::size_t kLanes = 4;
  static constexpr float kNu = 3;         ///< degrees of freedom: tails of real matches, as fitted
  static constexpr float kReach_px = 10;  ///< an outlier is found within this
  static constexpr double kNoiseFactors[] = {0.63, 1.0, 1.6, 2.5, 4.0};  ///< of the predicted noise
  static constexpr std::size_t kPredicted = 1;                           ///< the factor 1
  static constexpr double kNoiseSpread = 0.5;      ///< standard deviation of log(noise / predicted) ...
  static constexpr double kPredictionWeight = 30;  ///< ... which counts as so many points
  static constexpr float kFarthest = 1e12F;  ///< squared residuals are cut off, so that none is infinite

  /// True if this noise gives the shortest description so far.
  bool try_noise(std::size_t k) {
    const double noise_px = kNoiseFactors[k] * in_->noise_px;
    measure_losses(noise_px);
    grow();
    while (selected_.size() > 1 && prune()) {
    }
    const double cost = total_cost(noise_px, portable::log(kNoiseFactors[k]));
    if (!best_.empty() && !(cost < least_)) return false;
    least_ = cost;
    best_ = selected_;
    noise_px_ = noise_px;
    return true;
  }

  /// log(1 + x) for x >= 0, with an error of at most 3e-4: a polynomial in the mantissa.
  /// The standard library's function costs ten times as much.
  static Four log1p_of(const Four& x) {
    using Bits = detail::Int4;
    const Four y = 1 + x;
    Bits bits;
    std::memcpy(&bits, &y, sizeof bits);
    const Four exponent = __builtin_convertvector((bits >> 23) - 127, Four);
    bits = (bits & 0x007FFFFF) | 0x3F800000;
    Four m;
    std::memcpy(&m, &bits, sizeof m);
    // log2(m) on [1, 2]: least-squares polynomial of degree 4 with exact ends.
    const Four t = m - 1;
    const Four log2m = t * (1.4419F + t * (-0.7096F + t * (0.4148F + t * (-0.1948F + t * 0.0477F))));
    return 0.69314718F * (exponent + log2m);
  }

  /// One row per point, so that four lanes hold the residuals of four motions at one point.
  /// Each motion's sum over the points keeps its order.
  void transpose() {
    stride_ = (in_->motions + kLanes - 1) / kLanes * kLanes;
    image2_px2_.assign(stride_ * in_->points, kFarthest);
    depth2_.assign(stride_ * in_->points, 0);
    for (std::size_t h = 0; h < in_->motions; ++h) {
      const float *image2 = in_->image2_px2.data() + h * in_->stride,
                  *depth2 = in_->depth2.data() + h * in_->stride;
      for (std::size_t k = 0; k < in_->points; ++k) {
        image2_px2_[k * stride_ + h] = image2[k];
        depth2_[k * stride_ + h] = depth2[k];
      }
    }
  }

  void measure_losses(double noise_px) {
    loss_.resize(image2_px2_.size());
    const auto per_s2 = static_cast<float>(1 / (noise_px * noise_px));
    constexpr float kHalf = 0.5F * (kNu + 2);
    const Four worst = kHalf * log1p_of(Four{} + kReach_px * kReach_px * per_s2 / kNu),
               farthest = Four{} + kFarthest;
    for (std::size_t k = 0; k < loss_.size(); k += kLanes) {
      const Four chi2 =
          detail::load_four(image2_px2_.data() + k) * per_s2 + detail::load_four(depth2_.data() + k);
      const Four loss = kHalf * log1p_of((chi2 < farthest ? chi2 : farthest) / kNu);
      detail::store_lane(loss_.data() + k, loss < worst ? loss : worst);
    }
    worst_ = worst[0];
  }

  /// What each motion saves beside those that explain the points now.
  void measure_savings() {
    savings_.resize(stride_);
    std::size_t h = 0;
    for (; h + 4 * kLanes <= stride_; h += 4 * kLanes) sum_savings<4>(h);
    for (; h + 2 * kLanes <= stride_; h += 2 * kLanes) sum_savings<2>(h);
    if (h < stride_) sum_savings<1>(h);
    for (h = 0; h < in_->motions; ++h) savings_[h] -= in_->prices[h];
  }
  /// Several sums at once, because each waits for its last addition.
  template <std::size_t kFours>
  void sum_savings(std::size_t first) {
    Four sum[kFours] = {};
    const Four none{};
    const float *loss = loss_.data() + first, *weights = in_->weights.data();
    for (std::size_t k = 0; k < in_->points; ++k, loss += stride_)
      for (std::size_t p = 0; p < kFours; ++p) {
        const Four saved = least_loss_[k] - detail::load_four(loss + p * kLanes);
        sum[p] += weights[k] * (saved > none ? saved : none);
      }
    for (std::size_t p = 0; p < kFours; ++p) detail::store_lane(savings_.data() + first + p * kLanes, sum[p]);
  }

  float loss(std::size_t h, std::size_t k) const { return loss_[k * stride_ + h]; }
  void explain(std::size_t h) {
    for (std::size_t k = 0; k < in_->points; ++k) least_loss_[k] = std::min(least_loss_[k], loss(h, k));
  }

  /// Adds the motion that saves most, as long as one saves anything.
  void grow() {
    selected_.clear();
    least_loss_.assign(in_->points, worst_);
    while (selected_.size() < in_->motions) {
      measure_savings();
      const auto end = savings_.begin() + static_cast<std::ptrdiff_t>(in_->motions);
      const auto best = std::max_element(savings_.begin(), end);
      if (!(*best > 0) && !selected_.empty()) return;
      selected_.push_back(static_cast<std::size_t>(best - savings_.begin()));
      explain(selected_.back());
    }
  }

  /// Drops the motion that saves least beside the others, if that is less than its price.
  bool prune() {
    measure_savings_beside_others();
    const auto worst = std::min_element(savings_.begin(), savings_.end());
    if (!(*worst < 0)) return false;
    selected_.erase(selected_.begin() + (worst - savings_.begin()));
    return true;
  }
  /// A motion saves at the points that it explains best: there, the second best loss minus its own.
  void measure_savings_beside_others() {
    const std::size_t none = selected_.size();
    savings_.assign(none + 1, 0);
    for (std::size_t k = 0; k < in_->points; ++k) {
      float least = worst_, second = worst_;
      std::size_t owner = none;
      for (std::size_t s = 0; s < none; ++s) {
        const float now = loss(selected_[s], k);
        second = std::min(second, std::max(least, now));
        owner = now < least ? s : owner;
        least = std::min(least, now);
      }
      savings_[owner] += in_->weights[k] * (second - least);
    }
    savings_.pop_back();
    for (std::size_t s = 0; s < none; ++s) savings_[s] -= in_->prices[selected_[s]];
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
    return cost + 2 * portable::log(noise_px) * weights;
  }

  const Input* in_ = nullptr;                      ///< during select() only
  std::size_t stride_ = 0;                         ///< motions, padded to whole packs
  std::vector<float> image2_px2_, depth2_, loss_;  ///< points x stride_
  std::vector<float> least_loss_;                  ///< per point
  std::vector<float> savings_;                     ///< per motion
  std::vector<std::size_t> selected_, best_;
  float worst_ = 0;
  double noise_px_ = 0, least_ = 0;
};

}  // namespace dynfilter
