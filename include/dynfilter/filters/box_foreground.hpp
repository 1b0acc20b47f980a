// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/context/context.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// The depth [m] up to which a box shows its object rather than what is behind it: the split of Otsu (1979)
/// over the inverse depths of the box, where the two sides are at least 15 % apart and the near one holds 10
/// % of the samples or more; else infinity (all of the box is foreground). Samples: a 24 x 24 grid of the
/// depth image, or the depths of the given features where there is no image.
inline double foreground_depth_m(Context& context, const cv::Rect2f& box,
                                 const std::vector<std::size_t>& inside) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  constexpr int kGrid = 24;
  std::vector<float> inverse;
  const FrameView& frame = context.frame();
  if (!frame.depth.empty()) {
    const DepthSampler depth(frame.depth, frame.depth_unit_m, 1e9);
    for (int r = 0; r < kGrid; ++r)
      for (int c = 0; c < kGrid; ++c) {
        const float z = depth.at({box.x + box.width * (static_cast<float>(c) + 0.5F) / kGrid,
                                  box.y + box.height * (static_cast<float>(r) + 0.5F) / kGrid});
        if (valid_depth(z)) inverse.push_back(1 / z);
      }
  } else {
    for (const std::size_t i : inside)
      if (valid_depth(context.depths_m()[i])) inverse.push_back(1 / context.depths_m()[i]);
  }
  if (inverse.size() < 8) return kAll;

  std::sort(inverse.begin(), inverse.end());
  const auto n = static_cast<double>(inverse.size());
  double total = 0;
  for (const float v : inverse) total += static_cast<double>(v);
  double far_sum = 0, best = 0, gap_end = 0;
  std::size_t split = 0;
  for (std::size_t k = 1; k < inverse.size(); ++k) {
    far_sum += static_cast<double>(inverse[k - 1]);
    const double far_n = static_cast<double>(k), near_n = n - far_n;
    const double difference = (total - far_sum) / near_n - far_sum / far_n;
    const double between = far_n * near_n * difference * difference;
    if (between <= best) continue;
    best = between;
    split = k;
    gap_end = difference / (total / n);
  }
  const bool two_surfaces = gap_end > 0.15 && n - static_cast<double>(split) >= 0.1 * n;
  return two_surfaces ? 1.0 / static_cast<double>(inverse[split]) : kAll;
}

}  // namespace dynfilter
