// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <string>

namespace dynfilter {

class Evidence;

/// Base of rejectors and combinators.
/// A filter has no global state. Use one object per camera stream, from one thread at a time.
class Filter {
 public:
  Filter() = default;
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;
  virtual ~Filter() = default;

  virtual std::string name() const = 0;
  virtual Needs needs() const = 0;  ///< inputs without which it is skipped, and those that it uses if present

  /// Casts votes for the features of the current frame. `votes` has one entry per feature, all Unknown on
  /// entry. Leave a feature Unknown if it cannot be judged. Unusual data must not throw.
  virtual void apply(const Evidence& evidence, Votes& votes) = 0;

  /// Clears the state from earlier frames.
  /// Called on loss of tracking, after relocalisation and when time jumps.
  virtual void reset() {}
};

/// A filter F that says its name once, as the constant F::kName.
template <class F>
class NamedFilter : public Filter {
 public:
  std::string name() const final { return F::kName; }
};

}  // namespace dynfilter
