// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <string>

namespace dynfilter {

class Context;

/// A rejector, or a combinator of rejectors. An object without globals: one per camera stream, used by one
/// thread.
class Filter {
 public:
  Filter() = default;
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;
  virtual ~Filter() = default;

  virtual std::string name() const = 0;
  virtual Needs needs() const = 0;

  /// Casts votes for the current frame's features. `votes` comes in with one entry per feature, all Unknown;
  /// a feature that cannot be judged is left so. Odd data never throws.
  virtual void apply(Context& context, Votes& votes) = 0;

  /// Forgets what was learnt from earlier frames: called on loss of tracking, relocalisation and time jumps.
  virtual void reset() {}
};

}  // namespace dynfilter
