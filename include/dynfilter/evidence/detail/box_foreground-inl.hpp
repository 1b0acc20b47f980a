// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/box_foreground.hpp>

#include <dynfilter/cluster/depth_split.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter {

DYNFILTER_INLINE cv::Rect2f features_in_box(const Evidence& evidence, cv::Rect2f box, double expand_px,
                                            const LateResult& late, BoxScratch& scratch,
                                            std::vector<std::size_t>& inside) {
  const cv::Rect2f given = box;
  const auto by = static_cast<float>(expand_px);
  box = {box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by};
  const cv::Point2f flow =
      late.median_flow([&](const cv::Point2f& px) { return box.contains(px); }, scratch.x, scratch.y);
  inside.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const cv::Point2f then = late.then_px(i, flow);
    if (then.x >= box.x && then.y >= box.y && then.x <= box.x + box.width && then.y <= box.y + box.height)
      inside.push_back(i);
  }
  return {given.x + flow.x, given.y + flow.y, given.width, given.height};
}

DYNFILTER_INLINE double foreground_depth_m(const Evidence& evidence, const cv::Rect2f& box,
                                           const std::vector<std::size_t>& inside, BoxScratch& scratch) {
  constexpr int kGrid = 24;
  std::vector<float>& inverse = scratch.depths;
  inverse.clear();
  const FrameView& frame = evidence.frame();
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
      if (valid_depth(evidence.depths_m()[i])) inverse.push_back(1 / evidence.depths_m()[i]);
  }
  return nearer_surface_m(inverse);
}

DYNFILTER_INLINE double consensus_depth_m(const Evidence& evidence, const std::vector<std::size_t>& inside,
                                          double margin_m, BoxScratch& scratch) {
  std::vector<float>& depths = scratch.depths;
  depths.clear();
  for (const std::size_t i : inside)
    if (valid_depth(evidence.depths_m()[i])) depths.push_back(evidence.depths_m()[i]);
  const std::optional<float> depth_m = densest_in_place(depths, static_cast<float>(2 * margin_m));
  return depth_m ? static_cast<double>(*depth_m) : std::numeric_limits<double>::infinity();
}

DYNFILTER_INLINE double box_foreground_m(const Evidence& evidence, const cv::Rect2f& box,
                                         const std::vector<std::size_t>& inside, BoxRefinement how,
                                         double margin_m, BoxScratch& scratch) {
  if (how == BoxRefinement::None) return std::numeric_limits<double>::infinity();
  return margin_m + (how == BoxRefinement::Depth ? foreground_depth_m(evidence, box, inside, scratch)
                                                 : consensus_depth_m(evidence, inside, margin_m, scratch));
}

}  // namespace dynfilter
