// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
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

inline void MaskComponents::build(const MaskLookup& mask) {
  mask_ = mask;
  runs_.clear();
  row_begin_.assign(1, 0);
  for (int row = 0; row < mask.labels().rows; ++row) {
    scan(row);
    row_begin_.push_back(runs_.size());
    join(row);
  }
  number();
}

inline void MaskComponents::scan(int row) {
  const int columns = mask_.labels().cols;
  const std::uint8_t* pixels = mask_.labels().ptr<std::uint8_t>(row);
  int x = 0;
  while (x < columns) {
    std::uint64_t eight = 1;
    if (x + 8 <= columns) std::memcpy(&eight, pixels + x, sizeof(eight));
    if (eight == 0) {
      x += 8;
      continue;
    }
    if (!mask_.counts(pixels[x])) {
      ++x;
      continue;
    }
    const int from = x;
    while (x < columns && mask_.counts(pixels[x])) ++x;
    runs_.push_back({from, x - 1, static_cast<std::uint32_t>(runs_.size())});
  }
}

inline void MaskComponents::join(int row) {
  if (row == 0) return;
  std::size_t above = row_begin_[static_cast<std::size_t>(row) - 1];
  const std::size_t begin = row_begin_[static_cast<std::size_t>(row)];
  for (std::size_t here = begin; here < runs_.size(); ++here) {
    while (above < begin && runs_[above].to < runs_[here].from - 1) ++above;
    for (std::size_t k = above; k < begin && runs_[k].from <= runs_[here].to + 1; ++k) unite(k, here);
  }
}

inline std::size_t MaskComponents::root(std::size_t k) {
  while (runs_[k].component != k) k = runs_[k].component = runs_[runs_[k].component].component;
  return k;
}

inline void MaskComponents::unite(std::size_t a, std::size_t b) {
  a = root(a), b = root(b);
  runs_[std::max(a, b)].component = static_cast<std::uint32_t>(std::min(a, b));
}

inline void MaskComponents::number() {
  count_ = 0;
  number_.resize(runs_.size());
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    const std::size_t r = root(k);
    number_[k] = r == k ? static_cast<std::uint32_t>(count_++) : number_[r];
  }
  for (std::size_t k = 0; k < runs_.size(); ++k) runs_[k].component = number_[k];
}

}  // namespace dynfilter
