// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/parameters.hpp>
#include <dynfilter/filters/box_foreground.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// What a semantic stage does with the features of a potentially moving object.
enum class SemanticRole {
  Prior,  ///< suspects: kept out of model fitting and judged more strictly, not dynamic for it
  Reject  ///< dynamic
};

enum class BoxRefinement { None, Depth };

struct SemanticBoxParams {
  SemanticRole role = SemanticRole::Prior;
  std::vector<std::string> classes = default_classes();
  double min_score = 0.4;
  double expand_px = 0;
  int max_age_frames = 5;
  BoxRefinement refine = BoxRefinement::None;
  double foreground_margin_m = 0.15;

  static std::vector<std::string> default_classes() {
    return {"person",   "bird",  "cat",   "dog",     "horse",     "sheep",    "cow",
            "elephant", "bear",  "zebra", "giraffe", "car",       "bicycle",  "motorcycle",
            "bus",      "train", "truck", "boat",    "aeroplane", "airplane", "motorbike"};
  }

  static const FieldTable<SemanticBoxParams>& fields() {
    using P = SemanticBoxParams;
    static const FieldTable<P> table{
        choice("role", &P::role, {{"prior", SemanticRole::Prior}, {"reject", SemanticRole::Reject}},
               "prior: suspects for later stages; reject: dynamic"),
        words("classes", &P::classes, "names of the classes that may move"),
        real("min_score", &P::min_score, "", {0, 1}, "boxes below this score are ignored"),
        real("expand_px", &P::expand_px, "px", {0, 1000}, "each box is made larger by this on every side"),
        integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
                "boxes computed on an older frame are moved to this one by flow, or dropped beyond this age"),
        choice("refine", &P::refine, {{"none", BoxRefinement::None}, {"depth", BoxRefinement::Depth}},
               "depth: only the foreground of a box counts"),
        real("foreground_margin_m", &P::foreground_margin_m, "m", {0, 10},
             "how far behind the foreground's surface still belongs to it"),
    };
    return table;
  }
};

/// Features inside a detector's boxes of classes that may move (RTS-SLAM sec. 3.2; SG-SLAM, YOLO-SLAM alike).
///
/// Formula:  p in box(class in classes, score >= min_score), grown by expand_px; with `refine: depth` also
///           z(p) <= foreground depth of the box + foreground_margin_m.
/// Needs:    boxes; for boxes of an older frame correspondences into it; for `refine: depth` depth.
/// Votes:    role reject: Dynamic inside. role prior: marks suspects. Never Static: a detector misses things.
/// Abstains: when no boxes came, or they are older than max_age_frames.
/// Blind to: classes that the detector does not know; whether the object moves at all.
/// State:    none. Cost: boxes x features comparisons, about 5 us.
class SemanticBoxFilter final : public Filter {
 public:
  using Params = SemanticBoxParams;
  static constexpr const char* kName = "semantic_box";
  static constexpr const char* kSummary = "features inside detector boxes of classes that may move";

  explicit SemanticBoxFilter(Params params = Params()) : params_(std::move(params)) {
    check_parameters(params_, kName);
  }

  std::string name() const override { return kName; }
  Needs needs() const override {
    return {Input::Detections, Input::Depth | Input::Correspondence, params_.max_age_frames};
  }

  void apply(Context& context, Votes& votes) override {
    const DetectionInput& input = *context.frame().detections;
    const bool late = input.frame_id >= 0 && input.frame_id != context.frame().id;
    const Match* match = nullptr;
    if (late) {
      const std::int64_t age = context.frame().id - input.frame_id;
      if (age < 0 || age > params_.max_age_frames) {
        context.note("boxes of frame " + std::to_string(input.frame_id) + " are too old");
        return;
      }
      match = &context.match_with(input.frame_id);
      if (match->reference == nullptr) {
        context.note("boxes of frame " + std::to_string(input.frame_id) + ", which is not kept");
        return;
      }
      context.note("boxes are " + std::to_string(age) + " frames late");
    }
    for (const Detection& detection : input.detections)
      if (wanted(detection)) judge(context, detection, match, votes);
  }

 private:
  bool wanted(const Detection& detection) const {
    return static_cast<double>(detection.score) >= params_.min_score &&
           std::find(params_.classes.begin(), params_.classes.end(), detection.class_name) !=
               params_.classes.end();
  }

  void judge(Context& context, const Detection& detection, const Match* match, Votes& votes) {
    inside(context, grown(detection.box), match);
    double farthest_m = 1e9;
    if (params_.refine == BoxRefinement::Depth)
      farthest_m = foreground_depth_m(context, detection.box, inside_) + params_.foreground_margin_m;
    for (const std::size_t i : inside_) {
      if (static_cast<double>(context.depths_m()[i]) > farthest_m) continue;
      if (params_.role == SemanticRole::Reject)
        votes.cast(i, Vote::Dynamic, detection.score);
      else
        votes.mark_prior(i);
    }
  }

  cv::Rect2f grown(const cv::Rect2f& box) const {
    const auto by = static_cast<float>(params_.expand_px);
    return {box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by};
  }

  /// The features in a box. A late box is held against where the features were then; for features that were
  /// not found there it moves with the median flow of those inside.
  void inside(const Context& context, const cv::Rect2f& box, const Match* match) {
    inside_.clear();
    const auto& pixels = context.pixels();
    cv::Point2f shift(0, 0);
    if (match != nullptr) shift = median_flow(context, box, *match);
    for (std::size_t i = 0; i < context.size(); ++i) {
      const cv::Point2f then = match == nullptr  ? pixels[i]
                               : match->found(i) ? match->correspondences.reference_px[i]
                                                 : pixels[i] - shift;
      if (then.x >= box.x && then.y >= box.y && then.x <= box.x + box.width && then.y <= box.y + box.height)
        inside_.push_back(i);
    }
  }

  cv::Point2f median_flow(const Context& context, const cv::Rect2f& box, const Match& match) {
    flow_x_.clear();
    flow_y_.clear();
    for (std::size_t i = 0; i < context.size(); ++i) {
      if (!match.found(i) || !box.contains(match.correspondences.reference_px[i])) continue;
      flow_x_.push_back(context.pixels()[i].x - match.correspondences.reference_px[i].x);
      flow_y_.push_back(context.pixels()[i].y - match.correspondences.reference_px[i].y);
    }
    if (flow_x_.empty()) return {0, 0};
    const auto middle = static_cast<std::ptrdiff_t>(flow_x_.size() / 2);
    std::nth_element(flow_x_.begin(), flow_x_.begin() + middle, flow_x_.end());
    std::nth_element(flow_y_.begin(), flow_y_.begin() + middle, flow_y_.end());
    return {flow_x_[flow_x_.size() / 2], flow_y_[flow_y_.size() / 2]};
  }

  Params params_;
  std::vector<std::size_t> inside_;
  std::vector<float> flow_x_, flow_y_;
};

}  // namespace dynfilter
