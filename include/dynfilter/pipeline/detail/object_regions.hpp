// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// Connected components of a mask (8 neighbours), numbered in the order of their first pixels. Stored as
/// pixel runs per row: one pass over the image, memory for the runs only. Memory is reused from call to call.
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

  std::size_t root(std::size_t k) {
    while (runs_[k].component != k) k = runs_[k].component = runs_[runs_[k].component].component;
    return k;
  }
  void unite(std::size_t a, std::size_t b) {
    a = root(a), b = root(b);
    runs_[std::max(a, b)].component = static_cast<std::uint32_t>(std::min(a, b));
  }
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

inline void MaskComponents::number() {
  count_ = 0;
  number_.resize(runs_.size());
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    const std::size_t r = root(k);
    number_[k] = r == k ? static_cast<std::uint32_t>(count_++) : number_[r];
  }
  for (std::size_t k = 0; k < runs_.size(); ++k) runs_[k].component = number_[k];
}

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
  /// Smallest score of a detection that is used, for boxes and instances. Not a key: code sets it.
  double min_score = 0.4;
  /// Labels that are used, for mask and components; empty: all except 0. Not a key: code sets it.
  std::vector<int> labels;
  double near_px = 0;
  BoxRefinement refine = BoxRefinement::None;
  /// Depth margin behind the foreground's surface that still belongs to it.
  static constexpr double kForegroundMargin_m = 0.15;
  /// Largest age of objects; objects of an older frame are carried to this one up to this age.
  static constexpr int kMaxAgeFrames = 30;

  static const FieldTable<ObjectRegionParams>& fields() {
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
        real("near_px", &P::near_px, "px", {0, 200},
             "distance from the object up to which votes count for it"),
        box_refinement("refine", &P::refine),
    };
    return table;
  }
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

  /// Shows each object to the visitor; it is valid during the visit. None if the input is missing or too old,
  /// with a note in `votes`.
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

  cv::Point2f flow_on(const MaskLookup& mask, const LateResult& late) {
    return late.median_flow([&](const cv::Point2f& px) { return mask.at(px); }, scratch_.x, scratch_.y);
  }

  ObjectRegion object_;                           ///< of one detection or mask
  std::vector<ObjectRegion> components_of_mask_;  ///< those after the last one only keep their memory
  DetectionFilter wanted_;
  MaskComponents components_;
  BoxScratch scratch_;
};

inline void ObjectRegions::find(const Evidence& evidence, const ObjectRegionParams& params, Votes& votes,
                                ObjectVisitor& visitor) {
  const FrameView& frame = evidence.frame();
  const bool detections = input(params) == Input::Detections;
  if (detections ? !frame.detections : !frame.mask) return votes.note("no " + to_string(input(params)));
  const LateResult late = detections ? LateResult::boxes(evidence, ObjectRegionParams::kMaxAgeFrames, votes)
                                     : LateResult::mask(evidence, ObjectRegionParams::kMaxAgeFrames, votes);
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
    if (!wanted_.accepts(detection)) continue;
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
  const double farthest_m = box_foreground_m(evidence, box, object.inside, params.refine,
                                             ObjectRegionParams::kForegroundMargin_m, scratch_);
  const std::vector<float>& depths_m = evidence.depths_m();
  const auto behind = [&](std::size_t i) { return static_cast<double>(depths_m[i]) > farthest_m; };
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

}  // namespace dynfilter
