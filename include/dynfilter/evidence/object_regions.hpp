// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/mask_components.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The semantic input that defines objects.
enum class ObjectSource {
  Boxes,      ///< boxes of the detections
  Instances,  ///< instance masks of the detections
  Mask,       ///< the frame's mask as one object
  Components  ///< connected components of the frame's mask
};

struct ObjectRegionParams {
  ObjectSource objects = ObjectSource::Boxes;
  std::vector<std::string> classes, except_classes;
  double min_score = 0.4;
  std::vector<int> labels;
  double near_px = 0;
  BoxRefinement refine = BoxRefinement::None;
  double foreground_margin_m = 0.15;
  int max_age_frames = 30;

  static const FieldTable<ObjectRegionParams>& fields();
};

/// Features of an object, both lists in increasing order.
struct ObjectRegion {
  std::vector<std::size_t> inside;  ///< features that belong to it
  std::vector<std::size_t> near;    ///< features whose votes count for it: inside and close to it
};

/// The objects that a semantic input shows in a frame.
class ObjectRegions {
 public:
  static Input input(const ObjectRegionParams& params) {
    return params.objects == ObjectSource::Boxes || params.objects == ObjectSource::Instances
               ? Input::Detections
               : Input::Mask;
  }

  /// Valid until the next call. Empty if the input is missing or too old, with a note in `votes`.
  Span<const ObjectRegion> find(const Evidence& evidence, const ObjectRegionParams& params, Votes& votes);

 private:
  void find_detections(const Evidence& evidence, const ObjectRegionParams& params, const LateResult& late);

  void find_box(const Evidence& evidence, const cv::Rect2f& given, const ObjectRegionParams& params,
                const LateResult& late);

  void find_instance(const Evidence& evidence, const MaskLookup& mask, const ObjectRegionParams& params,
                     const LateResult& late);

  void find_masks(const Evidence& evidence, const ObjectRegionParams& params, const LateResult& late);

  cv::Point2f flow_on(const MaskLookup& mask, const LateResult& late);

  ObjectRegion& add_object();
  Span<const ObjectRegion> found() const { return {objects_.data(), count_}; }

  std::vector<ObjectRegion> objects_;  ///< those after `count_` only keep their memory
  std::size_t count_ = 0;
  DetectionFilter wanted_;
  MaskComponents components_;
  BoxScratch scratch_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/object_regions-inl.hpp>
#endif
