// SPDX-License-Identifier: MIT
#pragma once

/* The plain C interface (C11): create a pipeline, hand in frames, read verdicts. For other languages, and for
 * programs that share no C++ library with this one. Link dynfilter::facade. All memory behind pointers of a
 * dynfilter_frame is the caller's and is not used after the call; that behind a dynfilter_verdicts is the
 * library's and lives until the next call with the same filter. One filter per camera stream and thread. */

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define DYNFILTER_C_API
#else
#define DYNFILTER_C_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* 1 in 0.1.0, the first release. A release that changes a layout here increments it.
   Compare it with dynfilter_abi_version(). */
#define DYNFILTER_ABI_VERSION 1

typedef struct dynfilter_filter dynfilter_filter;

/* Where in the host's tracking a frame is judged. Numbers do not change. */
enum dynfilter_call_point { DYNFILTER_BEFORE_POSE = 0, DYNFILTER_AFTER_POSE = 1, DYNFILTER_AT_KEYFRAME = 2 };
/* How the host knows the pose of a frame. */
enum dynfilter_pose_kind {
  DYNFILTER_POSE_NONE = 0,
  DYNFILTER_POSE_PREDICTED = 1,
  DYNFILTER_POSE_ESTIMATED = 2,
  DYNFILTER_POSE_REFINED = 3
};
/* What is known of the camera's motion without the images: a gyroscope knows its turn. */
enum dynfilter_motion_kind {
  DYNFILTER_MOTION_NONE = 0,
  DYNFILTER_MOTION_TURN = 1,
  DYNFILTER_MOTION_TURN_AND_TRANSLATION = 2
};
/* Type of the depth image. */
enum dynfilter_depth_type { DYNFILTER_DEPTH_NONE = 0, DYNFILTER_DEPTH_U16 = 1, DYNFILTER_DEPTH_F32 = 2 };

/* A feature, in pixels of the distorted image. */
typedef struct dynfilter_keypoint {
  float x_px, y_px, size_px, angle_deg, response;
  int32_t octave;
} dynfilter_keypoint;

/* A box of a detector, in pixels of the distorted image. */
typedef struct dynfilter_box {
  float x_px, y_px, width_px, height_px; /* left upper corner and size */
  float score;
  int32_t class_id, track_id; /* -1: none */
  const char* class_name;     /* e.g. "person"; NULL: none */
  const uint8_t* mask;        /* instance mask, width_px x height_px of the frame, 0 = outside; NULL: none */
  size_t mask_stride_bytes;   /* 0: no padding */
} dynfilter_box;

/* Fill with dynfilter_frame_init() first. Pointers may be NULL for what is not there. A stride that is
 * shorter than a row, and a count without its array, are errors. */
typedef struct dynfilter_frame {
  size_t struct_size; /* set by dynfilter_frame_init() */
  int64_t id;         /* grows from frame to frame */
  double timestamp_s;

  size_t keypoint_count;
  const dynfilter_keypoint* keypoints;
  const float* depth_m;          /* per keypoint; <= 0 or NaN: none */
  const float* right_u_px;       /* stereo: column in the right image; < 0 or NaN: none */
  const uint8_t* descriptors;    /* keypoint_count rows */
  size_t descriptor_bytes;       /* of a row, e.g. 32 */
  const int64_t* map_point_ids;  /* per keypoint, -1: none */
  const float* map_points_xyz_m; /* 3 per keypoint, in the world */

  int32_t width_px, height_px; /* of the images, and of the camera without any */
  const uint8_t* grey;         /* 8 bits */
  size_t grey_stride_bytes;    /* 0: no padding */
  const uint8_t* right_grey;   /* stereo: the rectified right image */
  size_t right_grey_stride_bytes;
  const void* depth;
  size_t depth_stride_bytes;
  int32_t depth_type;  /* enum dynfilter_depth_type */
  double depth_unit_m; /* metres per unit */
  const uint8_t* mask; /* 0 = background */
  size_t mask_stride_bytes;
  int64_t mask_frame_id; /* the frame it was computed on, -1: this one */

  int32_t has_camera;
  double fx_px, fy_px, cx_px, cy_px, distortion[5], baseline_fx_px_m;

  int32_t pose_kind;  /* enum dynfilter_pose_kind */
  double rotation[9]; /* matrix of T_world_camera, row-major */
  double translation_m[3];

  int32_t motion_kind;       /* enum dynfilter_motion_kind */
  int64_t motion_frame_id;   /* the motion begins there, -1: at the frame before */
  double motion_rotation[9]; /* matrix of T_current_reference, row-major */
  double motion_translation_m[3];
  double motion_covariance[36]; /* of a left perturbation: translation [m], rotation [rad]; row-major */

  int32_t has_boxes; /* 1 with a count of 0: the detector found nothing */
  size_t box_count;
  const dynfilter_box* boxes;
  int64_t boxes_frame_id;

  const int32_t* match_index; /* per keypoint its index in the frame below, -1: none; NULL: no matches */
  int64_t match_frame_id;     /* a frame that was processed before */
} dynfilter_frame;

/* What dynfilter_process() says of each keypoint. Valid until the next call with the filter. */
typedef struct dynfilter_verdicts {
  size_t count;            /* of the arrays, the frame's keypoint_count */
  const uint8_t* keep;     /* 0: on something that moves */
  const int8_t* decision;  /* 1 dynamic, 0 unknown (kept), -1 static */
  const float* suspicion;  /* [0, 1]; negative: no stage judged it */
  const uint64_t* reasons; /* bit k: stage k called it dynamic, see dynfilter_stage_name() */
  size_t stage_count, rejected;
  int32_t wait_for_keyframe;
  double correspondence_ms, total_ms;
  const char* notes;   /* lines; "" if none */
  const float* weight; /* [0, 1]: what an optimiser multiplies the keypoint's information with */
} dynfilter_verdicts;

/* What one stage of the pipeline did with the last frame. Strings live until the next call with the filter.
 */
typedef struct dynfilter_stage_report {
  const char* name; /* of the filter or combinator */
  const char* path; /* its place in the pipeline file */
  const char* note; /* why it was skipped, which model was used, ...; "" if nothing */
  int32_t skipped;  /* an input was missing */
  int32_t failed;   /* its votes count as unknown */
  size_t judged, dynamic, unknown;
  size_t prior; /* suspects that are kept out of the fit of models */
  double time_ms;
} dynfilter_stage_report;

/* Of the library that is loaded. */
DYNFILTER_C_API int dynfilter_abi_version(void);
/* Of the library that is loaded, such as "0.1.0". */
DYNFILTER_C_API const char* dynfilter_version(void);

/* NULL when the pipeline cannot be used: `error` (may be NULL) then holds the reason, cut to error_size.
 * dynfilter_create: a pipeline by its name ("dynfilter"), by the path of a file, or as YAML text.
 * A line break or a `{` marks YAML text. Names are searched in the folders of the environment variable
 * DYNFILTER_PRESETS, then in share/dynfilter/pipelines of the installation. */
DYNFILTER_C_API dynfilter_filter* dynfilter_create(const char* name_path_or_text, char* error,
                                                   size_t error_size);
/* The same for the path of a pipeline file only. */
DYNFILTER_C_API dynfilter_filter* dynfilter_create_from_file(const char* path, char* error,
                                                             size_t error_size);
/* The same for YAML text only. */
DYNFILTER_C_API dynfilter_filter* dynfilter_create_from_text(const char* yaml, char* error,
                                                             size_t error_size);
/* NULL is fine. */
DYNFILTER_C_API void dynfilter_destroy(dynfilter_filter* filter);

/* Sets all members to "not there". Always call it first. */
DYNFILTER_C_API void dynfilter_frame_init(dynfilter_frame* frame);
/* Does what needs no keypoints, with `grey`, its size and `timestamp_s` of the next frame. May run in a
 * thread beside the host's own work. It ends before the next call with this filter. 0 done. */
DYNFILTER_C_API int dynfilter_prepare(dynfilter_filter* filter, const dynfilter_frame* frame);
/* 0 done, else failed: see dynfilter_last_error(). `call_point`: enum dynfilter_call_point. */
DYNFILTER_C_API int dynfilter_process(dynfilter_filter* filter, const dynfilter_frame* frame, int call_point,
                                      dynfilter_verdicts* verdicts);
/* A better pose of a frame that was processed before: its id, pose_kind, rotation and translation_m. What
 * the host's tracker made of it gives verdicts on map points, and lets the pipeline doubt itself: the
 * keypoints as they were judged, without those that were rejected, with their map_point_ids, and how many
 * matches agree with the host's map (inliers) and do not (outliers); 0 if it does not say. 0 done. */
DYNFILTER_C_API int dynfilter_update_pose(dynfilter_filter* filter, const dynfilter_frame* frame,
                                          size_t inliers, size_t outliers);
/* The host lost its pose: the poses of earlier frames are forgotten, the rest is kept. 0 done. */
DYNFILTER_C_API int dynfilter_lost(dynfilter_filter* filter);
/* Map points that move, by the verdicts of all frames: how many there are. Writes the least `capacity` of
 * their ids, in order. */
DYNFILTER_C_API size_t dynfilter_moved_map_points(const dynfilter_filter* filter, int64_t* ids,
                                                  size_t capacity);
/* Forgets all earlier frames. 0 done. */
DYNFILTER_C_API int dynfilter_reset(dynfilter_filter* filter);
/* Writes each frame and verdict from now on to this file, for `dynfilter replay`. It ends at max_mb
 * megabytes, with the filter, and with "". Replaces the file. 0 done. */
DYNFILTER_C_API int dynfilter_record(dynfilter_filter* filter, const char* file, int max_mb);
/* Of the last frame; "" beyond stage_count. */
DYNFILTER_C_API const char* dynfilter_stage_name(const dynfilter_filter* filter, size_t stage);
/* 0 done, else there is no such stage. `report_size`: sizeof(dynfilter_stage_report), so that later versions
 * can add to its end. */
DYNFILTER_C_API int dynfilter_get_stage_report(const dynfilter_filter* filter, size_t stage,
                                               dynfilter_stage_report* report, size_t report_size);
/* Why the last call failed; "" if none did. Valid until the next call. */
DYNFILTER_C_API const char* dynfilter_last_error(const dynfilter_filter* filter);

#ifdef __cplusplus
}
#endif
