// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <opencv2/core/types.hpp>
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

/// Features in a box grown by `expand_px`, border included.
/// A late box is compared with the features' positions in its frame.
/// Features without such a position use the median flow of the features inside.
/// Returns the box in the current frame, not grown.
cv::Rect2f features_in_box(const Evidence& evidence, cv::Rect2f box, double expand_px, const LateResult& late,
                           BoxScratch& scratch, std::vector<std::size_t>& inside);

/// Largest depth [m] of the object in a box, beyond which is background.
/// Splits the depths of the box into two surfaces and returns the bound of the nearer one.
/// Infinity if the box has one surface only.
/// Samples a 24 x 24 grid of the depth image, or the depths of `inside` without an image.
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/box_foreground-inl.hpp>
#endif
