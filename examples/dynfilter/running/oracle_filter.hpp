// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

namespace dynfilter::command {

/// Labels of the current frame (CV_8UC1, 0: static). The player of the sequence fills it.
struct OracleLabels {
  cv::Mat labels;
};

/// Upper bound with perfect knowledge.
/// Rejects the features on a labelled mover of a synthetic sequence, moving or not.
/// The filter belongs to the command, and shows how to add one without the toolkit.
class OracleFilter final : public NamedFilter<OracleFilter> {
 public:
  static constexpr const char* kName = "oracle";

  explicit OracleFilter(std::shared_ptr<const OracleLabels> truth) : truth_(std::move(truth)) {}

  Needs needs() const override { return {}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    const cv::Mat& labels = truth_->labels;
    if (labels.empty()) throw Error("no label image");  // a row without votes would be that of `none`
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const int x = cvRound(evidence.pixels()[i].x), y = cvRound(evidence.pixels()[i].y);
      if (x < 0 || y < 0 || x >= labels.cols || y >= labels.rows) continue;
      votes.cast(i, labels.at<std::uint8_t>(y, x) > 0 ? Vote::Dynamic : Vote::Static);
    }
  }

 private:
  std::shared_ptr<const OracleLabels> truth_;
};

/// True if a stage of the pipeline has this name.
inline bool uses_stage(const Pipeline& pipeline, const std::string& name) {
  bool found = false;
  for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
    if (const Stage* root = pipeline.stages(point))
      root->for_each([&](const Stage& stage, int) { found = found || stage.name() == name; });
  }
  return found;
}

/// Throws IoError if the pipeline needs labels and `where`, a sequence or a frame, has none.
/// For the command and for Python alike.
inline void require_labels(const Pipeline& pipeline, bool has_labels, const std::string& where) {
  if (!has_labels && uses_stage(pipeline, OracleFilter::kName))
    throw IoError(where + ": has no label images, which `oracle` needs: choose another pipeline");
}

/// The inputs that the filter `name` needs, in words. Labels are no input of a frame: only the oracle reads
/// them.
inline std::string needs_text(const std::string& name, Input inputs) {
  if (name != OracleFilter::kName) return to_string(inputs);
  return inputs == Input::None ? "labels of the sequence" : to_string(inputs) + ", labels of the sequence";
}

inline void add_oracle(Registry& registry, std::shared_ptr<const OracleLabels> truth) {
  FilterCard card;
  card.name = OracleFilter::kName;
  card.summary = "features on labelled movers of a synthetic sequence (only in this command)";
  registry.add({card, [truth](const YamlNode& node) -> std::unique_ptr<Filter> {
                  if (!node.is_none()) node.fail("`oracle` has no parameters");
                  return std::make_unique<OracleFilter>(truth);
                }});
}

}  // namespace dynfilter::command
