// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/cluster/depth_split.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// Method that separates the object in a box from its background.
enum class BoxRefinement {
  None,
  Depth,     ///< splits the depths of the box into two surfaces and uses the nearer one
  Consensus  ///< uses the depth that most features of the box share
};

template <class P>
Field<P> box_refinement(const char* name, BoxRefinement P::*member) {
  return choice(name, member,
                {{"none", BoxRefinement::None},
                 {"depth", BoxRefinement::Depth},
                 {"consensus", BoxRefinement::Consensus}},
                "foreground of a box: none uses the whole box, depth the nearer of two surfaces, consensus "
                "the depth that most features share");
}

/// Buffers of the functions below.
struct BoxScratch {
  std::vector<float> x, y, depths;
};

/// Features in a box grown by `expand_px`, border included. A late box is compared with the features'
/// positions in its frame. Features without such a position use the median flow of the features inside.
/// Returns the box in the current frame, not grown.
cv::Rect2f features_in_box(const Evidence& evidence, cv::Rect2f box, double expand_px, const LateResult& late,
                           BoxScratch& scratch, std::vector<std::size_t>& inside);

/// Largest depth [m] of the object in a box, beyond which is background. Splits the depths of the box into
/// two surfaces and returns the bound of the nearer one. Infinity if the box has one surface only. Samples a
/// 24 x 24 grid of the depth image, or the depths of `inside` without an image.
double foreground_depth_m(const Evidence& evidence, const cv::Rect2f& box,
                          const std::vector<std::size_t>& inside, BoxScratch& scratch);

/// Median depth [m] of the layer that contains most features of a box, 2 `margin_m` thick.
/// The nearest layer wins a tie. Infinity without depths.
/// YOLO-SLAM (Wu et al. 2022) separates an object from its background in this way.
double consensus_depth_m(const Evidence& evidence, const std::vector<std::size_t>& inside, double margin_m,
                         BoxScratch& scratch);

/// Depth [m] beyond which the features of a box are background.
double box_foreground_m(const Evidence& evidence, const cv::Rect2f& box,
                        const std::vector<std::size_t>& inside, BoxRefinement how, double margin_m,
                        BoxScratch& scratch);

inline cv::Rect2f features_in_box(const Evidence& evidence, cv::Rect2f box, double expand_px,
                                  const LateResult& late, BoxScratch& scratch,
                                  std::vector<std::size_t>& inside) {
  const cv::Rect2f given = box;
  const auto by = static_cast<float>(expand_px);
  box = {box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by};
  const cv::Point2f flow =
      late.median_flow([&](const cv::Point2f& px) { return box.contains(px); }, scratch.x, scratch.y);
  inside.clear();
  for (std::size_t i = 0, n = evidence.size(); i < n; ++i) {
    const cv::Point2f then = late.then_px(i, flow);
    if (then.x >= box.x && then.y >= box.y && then.x <= box.x + box.width && then.y <= box.y + box.height)
      inside.push_back(i);
  }
  return {given.x + flow.x, given.y + flow.y, given.width, given.height};
}

inline double foreground_depth_m(const Evidence& evidence, const cv::Rect2f& box,
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

inline double consensus_depth_m(const Evidence& evidence, const std::vector<std::size_t>& inside,
                                double margin_m, BoxScratch& scratch) {
  std::vector<float>& depths = scratch.depths;
  depths.clear();
  for (const std::size_t i : inside)
    if (valid_depth(evidence.depths_m()[i])) depths.push_back(evidence.depths_m()[i]);
  const std::optional<float> depth_m = densest_in_place(depths, static_cast<float>(2 * margin_m));
  return depth_m ? static_cast<double>(*depth_m) : std::numeric_limits<double>::infinity();
}

inline double box_foreground_m(const Evidence& evidence, const cv::Rect2f& box,
                               const std::vector<std::size_t>& inside, BoxRefinement how, double margin_m,
                               BoxScratch& scratch) {
  if (how == BoxRefinement::None) return std::numeric_limits<double>::infinity();
  return margin_m + (how == BoxRefinement::Depth ? foreground_depth_m(evidence, box, inside, scratch)
                                                 : consensus_depth_m(evidence, inside, margin_m, scratch));
}

}  // namespace dynfilter
