// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <optional>

namespace dynfilter {

/// Delays the first keyframe until few features are dynamic (Zhou et al. sec. 3.1.3).
/// The first frames are judged too.
/// A frame without any verdict also delays it. The first frame has none, as it has no reference.
class Initialisation {
 public:
  explicit Initialisation(const InitialisationParams& params = InitialisationParams()) : params_(params) {}

  void reset() { started_ = false, waited_ = 0, last_frame_.reset(); }
  /// Call when the host has created a keyframe. This ends the delay.
  void keyframe_made() { started_ = true; }

  /// Sets report.wait_for_keyframe. Features that the floor restored count as dynamic.
  void apply(Verdict& verdict);

 private:
  InitialisationParams params_;
  bool started_ = false;
  int waited_ = 0;
  std::optional<std::int64_t> last_frame_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/initialisation-inl.hpp>
#endif
