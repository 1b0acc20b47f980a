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

/// Selects the motions that explain the points by the shortest description (Rissanen, Automatica 1978).
///
/// The cost of a set H of motions, in nats:
///   sum_k w_k min_h L(e_hk^2 / s^2 + d_hk^2) + price |H|,   L(c) = (nu + 2) / 2 log(1 + c / nu)
/// L is a Student t density in the image. It is cut off where a point is an outlier, which may be anywhere
/// within `kReach_px`. e is the residual in the image [px], d that in depth in its own standard deviations.
/// w_k is the share of an independent point that point k counts as: errors of real matches are correlated
/// over tens of pixels. A second motion must save more than its six parameters cost. The search is greedy.
/// Cost: O(motions * points * selected). Owns its scratch.
class MotionSelection {
 public:
  /// Squared residuals of every motion at every point, one row per motion.
  struct Input {
    std::size_t motions = 0;
    std::size_t stride = 0;        ///< length of a row, a multiple of four
    Span<const float> image2_px2;  ///< not negative
    Span<const float> depth2;      ///< not negative
    Span<const float> weights;     ///< of the points of a row; 0: padding
    double price = 15;             ///< of a motion [nats]
    double noise_px = 0.3;         ///< s, per axis
  };

  /// Indices of the selected motions, the one that saves most first. Empty only without motions.
  const std::vector<std::size_t>& select(const Input& in) {
    selected_.clear();
    measure_losses(in);
    while (selected_.size() < in.motions) {
      std::size_t best = 0;
      float most = -1;
      for (std::size_t h = 0; h < in.motions; ++h)
        if (const float saved = savings(in, h); saved > most) most = saved, best = h;
      if (!(static_cast<double>(most) > in.price) && !selected_.empty()) break;
      selected_.push_back(best);
      for (std::size_t k = 0; k < in.stride; ++k)
        least_loss_[k] = std::min(least_loss_[k], loss_[best * in.stride + k]);
    }
    return selected_;
  }

 private:
  using Four = detail::Float4;
  static constexpr std::size_t kLanes = 4;
  static constexpr float kNu = 3;            ///< degrees of freedom: tails of real matches, as fitted
  static constexpr float kReach_px = 10;     ///< an outlier is found within this
  static constexpr float kFarthest = 1e12F;  ///< squared residuals are cut off, so that none is infinite

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

  void measure_losses(const Input& in) {
    const auto per_s2 = static_cast<float>(1 / (in.noise_px * in.noise_px));
    constexpr float kHalf = 0.5F * (kNu + 2);
    const Four worst = kHalf * log1p_of(Four{} + kReach_px * kReach_px * per_s2 / kNu),
               farthest = Four{} + kFarthest;
    loss_.resize(in.motions * in.stride);
    for (std::size_t k = 0; k < loss_.size(); k += kLanes) {
      const Four chi2 =
          detail::load_four(in.image2_px2.data() + k) * per_s2 + detail::load_four(in.depth2.data() + k);
      const Four loss = kHalf * log1p_of((chi2 < farthest ? chi2 : farthest) / kNu);
      detail::store_lane(loss_.data() + k, loss < worst ? loss : worst);
    }
    least_loss_.assign(in.stride, worst[0]);
  }

  /// What a motion saves beside those that explain the points now [nats].
  float savings(const Input& in, std::size_t h) const {
    Four sum{};
    const Four none{};
    for (std::size_t k = 0; k < in.stride; k += kLanes) {
      const Four saved =
          detail::load_four(least_loss_.data() + k) - detail::load_four(loss_.data() + h * in.stride + k);
      sum += detail::load_four(in.weights.data() + k) * (saved > none ? saved : none);
    }
    return detail::sum(sum);
  }

  std::vector<float> loss_;        ///< motions x stride
  std::vector<float> least_loss_;  ///< per point, of those selected
  std::vector<std::size_t> selected_;
};

}  // namespace dynfilter
