/* SPDX-License-Identifier: MIT
 * Compiled as C11: what any language that can call C does. */
#include <dynfilter/facade/dynfilter.h>
#include <stdio.h>
#include <string.h>

static int failed(const char* what) {
  printf("failed: %s\n", what);
  return 1;
}

enum { kFeatures = 10, kWidth = 64, kHeight = 48 };

int main(void) {
  char error[200];
  dynfilter_keypoint keypoints[kFeatures];
  const int32_t matches[kFeatures] = {0, 1, 2, 3, 4, 5, 6, 7, -1, 99};
  static uint8_t grey[kWidth * kHeight], mask[kWidth * kHeight];
  const dynfilter_box box = {-1.0F, 0.0F, 18.0F, 48.0F, 0.9F, 0, -1, "person", NULL, 0};
  dynfilter_frame frame;
  dynfilter_verdicts verdicts;
  const char* const yaml =
      "pipeline:\n"
      "  floor: { min_features: 0 }\n"
      "  before_pose:\n"
      "    any: [ { semantic_box: { role: reject } }, { semantic_mask: { role: reject, dilate_px: 0 } } ]\n";
  dynfilter_filter* filter;
  dynfilter_stage_report report;
  size_t i, stage;
  int saw_box = 0;

  if (dynfilter_abi_version() != DYNFILTER_ABI_VERSION) return failed("ABI version");
  if (dynfilter_create_from_file("/nowhere.yaml", error, sizeof error) != NULL) return failed("no such file");
  if (strstr(error, "/nowhere.yaml") == NULL) return failed("the reason names the file");
  if (dynfilter_create_from_text("pipeline: 3", NULL, 0) != NULL) return failed("a wrong pipeline");
  if (dynfilter_create("dynfiler", error, sizeof error) != NULL) return failed("no such preset");
  if (strstr(error, "did you mean `dynfilter`?") == NULL) return failed("the preset that was meant");
  filter = dynfilter_create("dynfilter", error, sizeof error);
  if (filter == NULL) return failed(error);
  dynfilter_destroy(filter);
  filter = dynfilter_create(yaml, error, sizeof error);
  if (filter == NULL) return failed(error);
  dynfilter_destroy(filter);
  filter = dynfilter_create_from_text(yaml, error, sizeof error);
  if (filter == NULL) return failed(error);

  dynfilter_frame_init(&frame);
  for (i = 0; i < kFeatures; ++i) {
    const dynfilter_keypoint keypoint = {(float)(6 * i), 20.0F, 31.0F, 0.0F, 0.0F, 0};
    keypoints[i] = keypoint;
  }
  memset(grey, 100, sizeof grey);
  mask[20 * kWidth + 54] = 1; /* on feature 9 */
  frame.keypoint_count = kFeatures;
  frame.keypoints = keypoints;
  frame.width_px = kWidth, frame.height_px = kHeight;
  frame.grey = grey, frame.grey_stride_bytes = kWidth;
  frame.mask = mask;
  frame.has_boxes = 1, frame.box_count = 1, frame.boxes = &box; /* 0, 6, 12 */
  if (dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) != 0)
    return failed(dynfilter_last_error(filter));
  if (verdicts.count != kFeatures || verdicts.rejected != 4) return failed("the number");
  for (i = 0; i < kFeatures; ++i)
    if (verdicts.keep[i] != (i >= 3 && i != 9)) return failed("the verdict");
  for (stage = 0; stage < verdicts.stage_count; ++stage)
    if ((verdicts.reasons[0] >> stage & 1) != 0 &&
        strcmp(dynfilter_stage_name(filter, stage), "semantic_box") == 0)
      saw_box = 1;
  if (!saw_box) return failed("the reason");
  /* what the flight recorder wrote is read by test/facade/recording_test.cpp */
  if (dynfilter_record(filter, "/nowhere/run.dfr", 10) == 0) return failed("a file that cannot be written");
  if (strstr(dynfilter_last_error(filter), "/nowhere/run.dfr") == NULL) return failed("the recording's file");
  if (dynfilter_record(filter, NULL, 10) == 0 || dynfilter_record(NULL, "x", 10) == 0)
    return failed("a recording without a file or a filter");
  for (stage = 0; stage < verdicts.stage_count; ++stage) {
    if (dynfilter_get_stage_report(filter, stage, &report, sizeof report) != 0) return failed("a report");
    if (strcmp(report.name, dynfilter_stage_name(filter, stage)) != 0) return failed("the report's name");
    if (strcmp(report.name, "semantic_box") == 0 &&
        (report.judged != kFeatures || report.dynamic != 3 || report.skipped || report.note == NULL))
      return failed("the report of the boxes");
  }
  if (dynfilter_get_stage_report(filter, stage, &report, sizeof report) == 0) return failed("no such stage");

  frame.mask = NULL, frame.has_boxes = 0;
  if (dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) != 0)
    return failed(dynfilter_last_error(filter));
  if (dynfilter_get_stage_report(filter, 1, &report, sizeof report) != 0 || !report.skipped ||
      strcmp(report.note, "skipped: no boxes") != 0)
    return failed("a stage without its input says so");

  frame.grey_stride_bytes = kWidth - 1;
  if (dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0)
    return failed("a short stride");
  if (strstr(dynfilter_last_error(filter), "grey_stride_bytes") == NULL) return failed("it is named");
  frame.grey_stride_bytes = 0;
  if (dynfilter_prepare(filter, &frame) != 0) return failed(dynfilter_last_error(filter));
  frame.match_index = matches, frame.match_frame_id = 0, frame.id = 1;
  if (dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) != 0)
    return failed(dynfilter_last_error(filter));

  frame.struct_size = 1;
  if (dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) == 0)
    return failed("another layout");
  if (strstr(dynfilter_last_error(filter), "struct_size") == NULL) return failed("the reason names it");
  dynfilter_frame_init(&frame);
  if (dynfilter_process(filter, &frame, 7, &verdicts) == 0) return failed("no such call point");
  if (dynfilter_process(filter, &frame, DYNFILTER_AFTER_POSE, &verdicts) != 0 || verdicts.count != 0)
    return failed("a frame without features");
  if (dynfilter_process(filter, NULL, 0, &verdicts) == 0 ||
      dynfilter_process(NULL, &frame, 0, &verdicts) == 0)
    return failed("NULL");
  if (dynfilter_reset(filter) != 0 || dynfilter_reset(NULL) == 0) return failed("reset");
  dynfilter_destroy(filter);
  dynfilter_destroy(NULL);
  printf("dynfilter %s: works\n", dynfilter_version());
  return 0;
}
