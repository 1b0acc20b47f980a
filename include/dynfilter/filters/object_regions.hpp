// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/filters/box_foreground.hpp>
#include <dynfilter/filters/mask_components.hpp>
#include <dynfilter/filters/mask_lookup.hpp>
#include <dynfilter/filters/semantic_input.hpp>
#include <string>
#include <vector>

namespace dynfilter {

enum class ObjectSource {
  Boxes,      ///< of the detector
  Instances,  ///< the masks of the detections
  Mask,       ///< all of the frame's mask is one object
  Components  ///< the connected parts of the frame's mask
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

  static const FieldTable<ObjectRegionParams>& fields() {
    using P = ObjectRegionParams;
    static const FieldTable<P> table{
        choice("objects", &P::objects,
               {{"boxes", ObjectSource::Boxes},
                {"instances", ObjectSource::Instances},
                {"mask", ObjectSource::Mask},
                {"components", ObjectSource::Components}},
               "boxes and instances: of the detections; mask: all of it is one object; components: its "
               "connected parts"),
        words("classes", &P::classes, "boxes, instances: names of classes; empty: every class"),
        words("except_classes", &P::except_classes, "boxes, instances: but these"),
        real("min_score", &P::min_score, "", {0, 1}, "boxes, instances: detections below are ignored"),
        integers("labels", &P::labels, {0, 255}, "mask, components: labels that count; empty: all but 0"),
        real("near_px", &P::near_px, "px", {0, 200}, "votes so near to the object count as votes on it"),
        box_refinement("refine", &P::refine),
        real("foreground_margin_m", &P::foreground_margin_m, "m", {0, 10},
             "how far behind the foreground's surface still belongs to it"),
        integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
                "objects of an older frame are carried to this one, or dropped beyond this age"),
    };
    return table;
  }
};

/// An object as features, both in growing order.
struct ObjectRegion {
  std::vector<std::size_t> inside;  ///< what belongs to it
  std::vector<std::size_t> near;    ///< what tells of it: inside and close to it
};

/// The objects of a frame that a semantic input shows.
class ObjectRegions {
 public:
  static Input input(const ObjectRegionParams& params) {
    return params.objects == ObjectSource::Boxes || params.objects == ObjectSource::Instances
               ? Input::Detections
               : Input::Mask;
  }

  /// Valid until the next call. None when the input is missing or too old; a note says so.
  const std::vector<ObjectRegion>& find(Context& context, const ObjectRegionParams& params) {
    objects_.clear();
    const FrameView& frame = context.frame();
    const bool detections = input(params) == Input::Detections;
    if (detections ? !frame.detections : !frame.mask) {
      context.note("no " + to_string(input(params)));
      return objects_;
    }
    const LateResult late = detections ? LateResult::boxes(context, params.max_age_frames)
                                       : LateResult::mask(context, params.max_age_frames);
    if (!late.usable()) return objects_;
    if (detections)
      find_detections(context, params, late);
    else
      find_masks(context, params, late);
    return objects_;
  }

 private:
  void find_detections(Context& context, const ObjectRegionParams& params, const LateResult& late) {
    const DetectionFilter filter{params.classes, params.except_classes, params.min_score};
    for (const Detection& detection : late.detections()) {
      if (!filter.wants(detection)) continue;
      objects_.emplace_back();
      if (params.objects == ObjectSource::Boxes)
        find_box(context, detection.box, params, late);
      else
        find_instance(context, MaskLookup(detection.mask, image_size(context.frame())), params, late);
    }
  }

  void find_box(Context& context, const cv::Rect2f& given, const ObjectRegionParams& params,
                const LateResult& late) {
    ObjectRegion& object = objects_.back();
    const cv::Rect2f box = features_in_box(context, given, 0, late, scratch_, object.inside);
    const double farthest_m =
        box_foreground_m(context, box, object.inside, params.refine, params.foreground_margin_m);
    const auto behind = [&](std::size_t i) {
      return static_cast<double>(context.depths_m()[i]) > farthest_m;
    };
    object.inside.erase(std::remove_if(object.inside.begin(), object.inside.end(), behind),
                        object.inside.end());
    features_in_box(context, given, params.near_px, late, scratch_, object.near);
    object.near.erase(std::remove_if(object.near.begin(), object.near.end(), behind), object.near.end());
  }

  void find_instance(const Context& context, const MaskLookup& mask, const ObjectRegionParams& params,
                     const LateResult& late) {
    const cv::Point2f flow = flow_on(mask, late);
    for (std::size_t i = 0; i < context.size(); ++i) {
      const cv::Point2f then = late.then_px(i, flow);
      const bool inside = mask.at(then);
      if (inside) objects_.back().inside.push_back(i);
      if (inside || mask.near(then, params.near_px)) objects_.back().near.push_back(i);
    }
  }

  void find_masks(const Context& context, const ObjectRegionParams& params, const LateResult& late) {
    const MaskLookup mask(late.labels(), image_size(context.frame()), params.labels);
    if (params.objects == ObjectSource::Mask) {
      objects_.emplace_back();
      return find_instance(context, mask, params, late);
    }
    components_.build(mask);
    objects_.resize(static_cast<std::size_t>(components_.count()));
    const cv::Point2f flow = flow_on(mask, late);
    for (std::size_t i = 0; i < context.size(); ++i) {
      const cv::Point2f then = late.then_px(i, flow);
      const auto add = [i](std::vector<std::size_t>& features) {
        if (features.empty() || features.back() != i) features.push_back(i);
      };
      components_.around(then, 0, [&](int c) { add(objects_[static_cast<std::size_t>(c)].inside); });
      components_.around(then, params.near_px,
                         [&](int c) { add(objects_[static_cast<std::size_t>(c)].near); });
    }
  }

  cv::Point2f flow_on(const MaskLookup& mask, const LateResult& late) {
    return late.median_flow([&](const cv::Point2f& px) { return mask.at(px); }, scratch_.x, scratch_.y);
  }

  std::vector<ObjectRegion> objects_;
  MaskComponents components_;
  BoxScratch scratch_;
};

}  // namespace dynfilter
