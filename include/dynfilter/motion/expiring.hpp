// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/portable_math.hpp>
#include <optional>

namespace dynfilter {

/// A conclusion from earlier frames. It expires with its premise: if no frame confirms it for a lifetime, it
/// is unknown again. A filter whose beliefs from earlier frames are all of this type cannot lock: an error
/// does not outlive its cause by more than that.
template <class T>
class Expiring {
 public:
  /// Half a second. Blur, an occlusion or a blink of the tracking lasts less. A camera in the hand may have
  /// turned to another place after more.
  static constexpr double kLifetime_s = 0.5;

  /// A frame begins, `passed_s` after the last one.
  void pass(double passed_s) {
    since_s_ += passed_s;
    if (since_s_ > kLifetime_s) value_.reset();
  }
  /// This frame shows it.
  void confirm(const T& value) { infer(value, 0); }
  /// It follows from a conclusion that was confirmed `since_s` ago, and expires with that one.
  void infer(const T& value, double since_s) {
    value_ = value;
    since_s_ = since_s;
  }
  void reset() { value_.reset(); }

  /// nullopt: unknown, because nothing was concluded or it has expired.
  const std::optional<T>& value() const { return value_; }
  /// Since the last confirmation [s], if known.
  double since_s() const { return since_s_; }

 private:
  std::optional<T> value_;
  double since_s_ = 0;
};

/// Mean of observations that lose weight with time. It begins as if half an observation had been 0, because
/// the first observation of a track is its least certain one.
struct RecentMean {
  static constexpr double kPriorWeight = 0.5;
  double value = 0, weight = kPriorWeight;

  bool observed() const { return weight > kPriorWeight; }  ///< whether it is more than the prior
  /// `keep`: share of the weight that earlier observations still have.
  void add(double new_value, double keep) {
    weight = keep * weight + 1;
    value += (new_value - value) / weight;
  }
};

/// A recent mean that is 0 again if nothing was observed for a lifetime.
class ExpiringMean {
 public:
  /// A frame begins, `passed_s` after the last one.
  void pass(double passed_s) {
    passed_s_ = passed_s;
    mean_.pass(passed_s);
  }
  /// `memory_s`: time constant with which observations lose weight.
  void observe(double value, double memory_s) {
    RecentMean mean = mean_.value().value_or(RecentMean());
    const double since_s = mean_.value() ? mean_.since_s() : passed_s_;
    mean.add(value, memory_s > 0 ? portable::exp(-since_s / memory_s) : 0);
    mean_.confirm(mean);
  }
  /// Takes over the mean of others: `since_s` ago, the first of them was confirmed for the last time.
  void infer(double value, double since_s) { mean_.infer({value, RecentMean::kPriorWeight}, since_s); }
  void reset() { mean_.reset(); }

  double value() const { return mean_.value() ? mean_.value()->value : 0; }  ///< 0 if it is not known
  /// Whether anything was observed within the lifetime.
  bool known() const { return mean_.value().has_value(); }
  /// Whether it was taken over from others only.
  bool inferred() const { return known() && !mean_.value()->observed(); }
  double since_s() const { return mean_.since_s(); }  ///< since the last observation [s]

 private:
  Expiring<RecentMean> mean_;
  double passed_s_ = 0;
};

}  // namespace dynfilter
