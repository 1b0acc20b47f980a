// SPDX-License-Identifier: MIT
// Compiled as C++11: what a fork that cannot move on writes.
#include <dynfilter/facade/facade.hpp>

#if __cplusplus >= 201402L && !defined(_MSC_VER)
#error "this file is here to be compiled as C++11"
#endif

#include <cstdio>

static int failed(const char* what) {
  std::printf("failed: %s\n", what);
  return 1;
}

int main() {
  namespace df = dynfilter::facade;
  if (df::abi_version() != df::kAbiVersion) return failed("ABI version");
  df::DynFilter filter;
  df::Frame frame;
  df::Verdicts verdicts;
  if (filter.process(frame, df::CallPoint::BeforePose, verdicts)) return failed("a pipeline out of nothing");
  if (filter.error() != "no pipeline is loaded") return failed("the reason");
  if (filter.load_text("pipeline: { before_pose: [ nonsense ] }")) return failed("a wrong pipeline");
  if (filter.error().find("nonsense") == std::string::npos) return failed("the reason names the stage");
  if (!filter.load_text(
          "pipeline:\n  floor: { min_features: 0 }\n  before_pose:\n    - semantic_box: { role: reject }\n"))
    return failed(filter.error().c_str());
  if (filter.load_file("/nowhere.yaml") || !filter.loaded())
    return failed("the pipeline that was there stays");

  for (int i = 0; i < 10; ++i)
    frame.keypoints.push_back(cv::KeyPoint(static_cast<float>(10 * i), 50.0F, 31.0F));
  df::Box person;
  person.box = cv::Rect2f(-5, 0, 30, 100);  // 0, 10, 20
  person.class_name = "person";
  frame.boxes.push_back(person);
  frame.has_boxes = true;
  if (!filter.process(frame, df::CallPoint::BeforePose, verdicts)) return failed(filter.error().c_str());
  for (std::size_t i = 0; i < 10; ++i)
    if (verdicts.keep[i] != (i < 3 ? 0 : 1)) return failed("the verdict");
  if (verdicts.rejected != 3 || verdicts.reasons[0] == 0) return failed("the report");
  if (filter.reports().size() != verdicts.stages.size()) return failed("a report for each stage");
  bool saw_box = false;
  for (const df::StageReport& report : filter.reports())
    saw_box = saw_box || (report.name == "semantic_box" && report.judged == 10 && report.dynamic == 3 &&
                          !report.skipped && report.time_ms > 0);
  if (!saw_box) return failed("the report of the boxes");
  if (filter.record("/nowhere/run.dfr") || filter.error().find("/nowhere/run.dfr") == std::string::npos)
    return failed("a recording that cannot be written");
  frame.has_boxes = false;
  if (!filter.process(frame, df::CallPoint::BeforePose, verdicts)) return failed(filter.error().c_str());
  if (!filter.reports().back().skipped || filter.reports().back().note != "skipped: no boxes")
    return failed("a stage without its input says so");
  df::DynFilter preset;
  if (preset.load("dynfiler") || preset.error().find("did you mean `dynfilter`?") == std::string::npos)
    return failed("no such preset");
  if (!preset.load("dynfilter") || !preset.load("pipeline: { before_pose: [ epipolar ] }"))
    return failed(preset.error().c_str());
  df::DynFilter moved(std::move(filter));
  if (!moved.reset() || !moved.process(frame, df::CallPoint::AfterPose, verdicts)) return failed("reset");
  if (verdicts.rejected != 0) return failed("nothing stands at that call point");
  std::printf("dynfilter %s: works\n", df::version());
  return 0;
}
