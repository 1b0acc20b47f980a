// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <vector>

namespace dynfilter::detail {

/// Selects the motions that are needed to explain the points, and gives each point to one of them.
///
/// Motion h explains point k by the fit f_hk = 1 / (1 + e^2 / s^2 + d^2). The residual in the image is e
/// [px], that in depth is d, in its standard deviations. The set H of motions is to have the largest
///   sum_k w_k max_h f_hk - price |H|.
/// This is facility location (FLoSS: Lazic et al., ICCV 2009). The greedy search adds the motion that gains
/// most, while that is more than the price. Its sum without prices is at least 63 % of the largest
/// (Nemhauser, Wolsey and Fisher, Mathematical Programming 1978).
/// Cost: O(motions * points * selected). Owns its scratch.
class MotionSelection {
 public:
  /// Squared residuals of every motion at every point, one row per motion.
  struct Input {
    std::size_t motions = 0;
    std::size_t stride = 0;        ///< length of a row, whole packs
    Span<const float> image2_px2;  ///< not negative
    Span<const float> depth2;      ///< not negative
    Span<const float> weights;     ///< of the points of a row; 0: padding
    double price = 0.5;            ///< of a motion, in points of weight 1
    double fit_px = 0.6;           ///< s
  };

  /// Indices of the selected motions, the one that gains most first. Empty only without motions.
  const std::vector<std::size_t>& select(const Input& in) {
    measure_fits(in);
    owner_.assign(in.stride, 0);
    best_fit_.assign(in.stride, 0);
    selected_.clear();
    while (selected_.size() < in.motions) {
      std::size_t best = 0;
      float most = -1;
      for (std::size_t h = 0; h < in.motions; ++h)
        if (const float gained = gain(in, h); gained > most) most = gained, best = h;
      if (!(static_cast<double>(most) > in.price) && !selected_.empty()) break;
      hand_over(fits_.data() + best * in.stride);
      selected_.push_back(best);
    }
    return selected_;
  }
  /// The selected motion that explains point k best, as a position in what select() returned, and its fit.
  std::size_t owner(std::size_t k) const { return owner_[k]; }
  float fit(std::size_t k) const { return best_fit_[k]; }

 private:
  void measure_fits(const Input& in) {
    const auto per_fit2 = static_cast<float>(1 / (in.fit_px * in.fit_px));
    fits_.resize(in.motions * in.stride);
    for (std::size_t k = 0; k < fits_.size(); k += Pack::kWidth)
      (1.0F / (1.0F + Pack::load(in.image2_px2.data() + k) * per_fit2 + Pack::load(in.depth2.data() + k)))
          .store(fits_.data() + k);
  }
  /// What a motion explains better than those that are selected.
  float gain(const Input& in, std::size_t h) const {
    Pack sum = 0;
    for (std::size_t k = 0; k < in.stride; k += Pack::kWidth) {
      const Pack better = Pack::load(fits_.data() + h * in.stride + k) - Pack::load(best_fit_.data() + k);
      sum += Pack::load(in.weights.data() + k) * max(better, Pack(0.0F));
    }
    return sum.sum();
  }
  void hand_over(const float* fits) {
    for (std::size_t k = 0; k < best_fit_.size(); ++k)
      if (fits[k] > best_fit_[k])
        owner_[k] = static_cast<std::uint32_t>(selected_.size()), best_fit_[k] = fits[k];
  }

  std::vector<float> fits_;  ///< motions x stride
  std::vector<std::size_t> selected_;
  std::vector<std::uint32_t> owner_;
  std::vector<float> best_fit_;
};

}  // namespace dynfilter::detail
