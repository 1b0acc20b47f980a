// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Restores rejected features, least suspicious first, until the floor is satisfied.
class Floor {
 public:
  explicit Floor(const FloorParams& params = FloorParams()) : params_(params) {}

  /// `host_min_features`: the tracker needs at least so many, whatever the parameters say.
  void apply(const FrameView& frame, int host_min_features, Verdict& verdict);

 private:
  /// Sorts rejected features by suspicion, then by position,
  /// so that the result does not depend on the order of the features.
  void rank(const FrameView& frame, const Verdict& verdict);

  /// All NaN positions count as one position, because NaN cannot be ordered.
  static cv::Point2f place_of(const FrameView& frame, std::size_t i);

  void raise_count(const FrameView& frame, int host_min_features, Verdict& verdict);

  void raise_coverage(const FrameView& frame, Verdict& verdict);

  /// The grid covers the image if its size is known, else the extent of the features.
  void lay_grid(const FrameView& frame);
  std::size_t cell_of(const FrameView& frame, std::size_t i) const;
  static void restore(Verdict& verdict, std::size_t i);

  FloorParams params_;
  std::vector<std::size_t> ranked_;
  std::vector<std::uint8_t> occupied_, covered_;
  float width_px_ = 0, height_px_ = 0;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/floor-inl.hpp>
#endif
