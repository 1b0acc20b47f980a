// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Connected components of a mask (8 neighbours), numbered in the order of their first pixels.
/// Stored as pixel runs per row: one pass over the image, memory for the runs only.
/// Memory is reused from call to call.
class MaskComponents {
 public:
  void build(const MaskLookup& mask);

  int count() const { return count_; }

  /// Calls f(component) for each component within `radius_px` of a pixel of the frame's image.
  /// May call it more than once per component.
  template <class F>
  void around(const cv::Point2f& px, double radius_px, const F& f) const {
    mask_.any_chord(px, radius_px, [&](int row, int from, int to) {
      const auto begin =
          runs_.begin() + static_cast<std::ptrdiff_t>(row_begin_[static_cast<std::size_t>(row)]);
      const auto end =
          runs_.begin() + static_cast<std::ptrdiff_t>(row_begin_[static_cast<std::size_t>(row) + 1]);
      auto run = std::lower_bound(begin, end, from, [](const Run& r, int x) { return r.to < x; });
      for (; run != end && run->from <= to; ++run) f(static_cast<int>(run->component));
      return false;
    });
  }

 private:
  struct Run {
    int from, to;  ///< columns, inclusive
    std::uint32_t component;
  };

  void scan(int row);

  /// Joins each run with the touching runs of the row above.
  void join(int row);

  std::size_t root(std::size_t k);
  void unite(std::size_t a, std::size_t b);
  /// Numbers the components. A root precedes all other runs of its component.
  void number();

  MaskLookup mask_;
  std::vector<Run> runs_;
  std::vector<std::size_t> row_begin_;
  std::vector<std::uint32_t> number_;
  int count_ = 0;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/mask_components-inl.hpp>
#endif
