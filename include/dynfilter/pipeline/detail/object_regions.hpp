// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <dynfilter/pipeline/detail/mask_components.hpp>
#include <opencv2/core.hpp>
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

inline const FieldTable<ObjectRegionParams>& ObjectRegionParams::fields() {
  using P = ObjectRegionParams;
  static const FieldTable<P> table{
      choice("objects", &P::objects,
             {{"boxes", ObjectSource::Boxes},
              {"instances", ObjectSource::Instances},
              {"mask", ObjectSource::Mask},
              {"components", ObjectSource::Components}},
             "boxes and instances use the detections, mask is one object, components uses its connected "
             "components"),
      words("classes", &P::classes,
            "names of the classes that are used, for boxes and instances; empty: all classes"),
      words("except_classes", &P::except_classes,
            "names of the classes that are excluded, for boxes and instances"),
      real("min_score", &P::min_score, "", {0, 1},
           "smallest score of a detection that is used, for boxes and instances"),
      integers("labels", &P::labels, {0, 255},
               "labels that are used, for mask and components; empty: all except 0"),
      real("near_px", &P::near_px, "px", {0, 200}, "distance from the object up to which votes count for it"),
      box_refinement("refine", &P::refine),
      real("foreground_margin_m", &P::foreground_margin_m, "m", {0, 10},
           "depth margin behind the foreground's surface that still belongs to it"),
      integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
              "largest age of objects; objects of an older frame are carried to this one up to this age"),
  };
  return table;
}

inline void ObjectRegions::find(const Evidence& evidence, const ObjectRegionParams& params, Votes& votes,
                                ObjectVisitor& visitor) {
  const FrameView& frame = evidence.frame();
  const bool detections = input(params) == Input::Detections;
  if (detections ? !frame.detections : !frame.mask) return votes.note("no " + to_string(input(params)));
  const LateResult late = detections ? LateResult::boxes(evidence, params.max_age_frames, votes)
                                     : LateResult::mask(evidence, params.max_age_frames, votes);
  if (!late.usable()) return;
  if (detections) return find_detections(evidence, params, late, visitor);
  const MaskLookup mask(late.labels(), image_size(frame), params.labels);
  if (params.objects == ObjectSource::Components)
    return find_components(evidence, mask, params, late, visitor);
  find_instance(evidence, mask, params, late, object_);
  visitor.visit(object_);
}

inline void ObjectRegions::find_detections(const Evidence& evidence, const ObjectRegionParams& params,
                                           const LateResult& late, ObjectVisitor& visitor) {
  wanted_.classes = params.classes;
  wanted_.except_classes = params.except_classes;
  wanted_.min_score = params.min_score;
  for (const Detection& detection : late.detections()) {
    if (!wanted_.wants(detection)) continue;
    if (params.objects == ObjectSource::Boxes)
      find_box(evidence, detection.box, params, late, object_);
    else
      find_instance(evidence, MaskLookup(detection.mask, image_size(evidence.frame())), params, late,
                    object_);
    visitor.visit(object_);
  }
}

inline void ObjectRegions::find_box(const Evidence& evidence, const cv::Rect2f& given,
                                    const ObjectRegionParams& params, const LateResult& late,
                                    ObjectRegion& object) {
  const cv::Rect2f box = features_in_box(evidence, given, 0, late, scratch_, object.inside);
  const double farthest_m =
      box_foreground_m(evidence, box, object.inside, params.refine, params.foreground_margin_m, scratch_);
  const auto behind = [&](std::size_t i) { return static_cast<double>(evidence.depths_m()[i]) > farthest_m; };
  object.inside.erase(std::remove_if(object.inside.begin(), object.inside.end(), behind),
                      object.inside.end());
  features_in_box(evidence, given, params.near_px, late, scratch_, object.near);
  object.near.erase(std::remove_if(object.near.begin(), object.near.end(), behind), object.near.end());
}

inline void ObjectRegions::find_instance(const Evidence& evidence, const MaskLookup& mask,
                                         const ObjectRegionParams& params, const LateResult& late,
                                         ObjectRegion& object) {
  object.inside.clear();
  object.near.clear();
  const cv::Point2f flow = flow_on(mask, late);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const cv::Point2f then = late.then_px(i, flow);
    const bool inside = mask.at(then);
    if (inside) object.inside.push_back(i);
    if (inside || mask.near(then, params.near_px)) object.near.push_back(i);
  }
}

inline void ObjectRegions::find_components(const Evidence& evidence, const MaskLookup& mask,
                                           const ObjectRegionParams& params, const LateResult& late,
                                           ObjectVisitor& visitor) {
  components_.build(mask);
  const auto count = static_cast<std::size_t>(components_.count());
  if (components_of_mask_.size() < count) components_of_mask_.resize(count);
  for (std::size_t c = 0; c < count; ++c)
    components_of_mask_[c].inside.clear(), components_of_mask_[c].near.clear();
  const cv::Point2f flow = flow_on(mask, late);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const cv::Point2f then = late.then_px(i, flow);
    const auto add = [i](std::vector<std::size_t>& features) {
      if (features.empty() || features.back() != i) features.push_back(i);
    };
    const auto object = [&](int c) -> ObjectRegion& {
      return components_of_mask_[static_cast<std::size_t>(c)];
    };
    components_.around(then, 0, [&](int c) { add(object(c).inside); });
    components_.around(then, params.near_px, [&](int c) { add(object(c).near); });
  }
  for (std::size_t c = 0; c < count; ++c) visitor.visit(components_of_mask_[c]);
}

inline cv::Point2f ObjectRegions::flow_on(const MaskLookup& mask, const LateResult& late) {
  return late.median_flow([&](const cv::Point2f& px) { return mask.at(px); }, scratch_.x, scratch_.y);
}

}  // namespace dynfilter
