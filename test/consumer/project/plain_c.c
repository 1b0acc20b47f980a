/* SPDX-License-Identifier: MIT */
#include <dynfilter/facade/dynfilter.h>
#include <stdio.h>

int main(void) {
  char error[200] = "";
  const dynfilter_keypoint keypoint = {10, 10, 31, 0, 0, 0};
  dynfilter_filter* filter =
      dynfilter_create_from_text("pipeline: { before_pose: [ background_motion ] }", error, sizeof error);
  dynfilter_frame frame;
  dynfilter_verdicts verdicts;
  dynfilter_frame_init(&frame);
  frame.keypoint_count = 1, frame.keypoints = &keypoint;
  if (filter == NULL || dynfilter_process(filter, &frame, DYNFILTER_BEFORE_POSE, &verdicts) != 0 ||
      verdicts.count != 1 || verdicts.keep[0] != 1) {
    printf("C11: is broken %s\n", error);
    return 1;
  }
  dynfilter_destroy(filter);
  puts("C11: works");
  return 0;
}
