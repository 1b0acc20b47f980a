// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/pipeline/detail/mask_components.hpp>
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

/// Sees the objects of a frame one after the other, in the order of the input.
class ObjectVisitor {
 public:
  virtual void visit(const ObjectRegion& object) = 0;

 protected:
  ~ObjectVisitor() = default;
};

/// The objects that a semantic input shows in a frame.
/// One at a time: a thousand boxes around the same features would take a list of all features each.
class ObjectRegions {
 public:
  static Input input(const ObjectRegionParams& params) {
    return params.objects == ObjectSource::Boxes || params.objects == ObjectSource::Instances
               ? Input::Detections
               : Input::Mask;
  }

  /// Shows each object to the visitor; it is valid during the visit. None if the input is missing or too old, with
  /// a note in `votes`.
  void find(const Evidence& evidence, const ObjectRegionParams& params, Votes& votes, ObjectVisitor& visitor);

 private:
  void find_detections(const Evidence& evidence, const ObjectRegionParams& params, const LateResult& late,
                       ObjectVisitor& visitor);
  void find_box(const Evidence& evidence, const cv::Rect2f& given, const ObjectRegionParams& params,
                const LateResult& late, ObjectRegion& object);
  void find_instance(const Evidence& evidence, const MaskLookup& mask, const ObjectRegionParams& params,
                     const LateResult& late, ObjectRegion& object);
  void find_components(const Evidence& evidence, const MaskLookup& mask, const ObjectRegionParams& params,
                       const LateResult& late, ObjectVisitor& visitor);

  cv::Point2f flow_on(const MaskLookup& mask, const LateResult& late);

  ObjectRegion object_;                           ///< of one detection or mask
  std::vector<ObjectRegion> components_of_mask_;  ///< those after the last one only keep their memory
  DetectionFilter wanted_;
  MaskComponents components_;
  BoxScratch scratch_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/object_regions-inl.hpp>
#endif
