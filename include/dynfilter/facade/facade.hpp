// SPDX-License-Identifier: MIT
#pragma once

// C++11 and OpenCV only: for programs that cannot move to C++17. Link dynfilter::facade, a shared library.
// The same pipelines, the same verdicts as with the headers, bit for bit.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#if defined(_WIN32)
#define DYNFILTER_FACADE_API
#else
#define DYNFILTER_FACADE_API __attribute__((visibility("default")))
#endif

namespace dynfilter {
namespace facade {

/// Grows when the layout of anything here changes.
enum { kAbiVersion = 1 };
/// Of the library that is loaded; compare it with kAbiVersion.
DYNFILTER_FACADE_API int abi_version() noexcept;
/// "0.1.0"
DYNFILTER_FACADE_API const char* version() noexcept;

/// Where in the host's tracking a frame is judged.
enum class CallPoint { BeforePose, AfterPose, AtKeyframe };
/// How the host knows the pose.
enum class PoseKind { None, Predicted, Estimated, Refined };
/// What is known of the camera's motion without the images: a gyroscope knows its turn.
enum class MotionKind { None, Turn, TurnAndTranslation };

/// Pixels of the distorted image.
struct Box {
  cv::Rect2f box;
  int class_id;
  std::string class_name;  ///< e.g. "person"; pipelines select by name
  float score;             ///< [0, 1]
  int track_id;
  cv::Mat mask;  ///< CV_8UC1 instance mask of the whole image; empty: none

  Box() : class_id(-1), score(1.0F), track_id(-1) {}
};

/// Pinhole camera with OpenCV's distortion.
struct Camera {
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  double distortion[5] = {};        ///< k1 k2 p1 p2 k3
  double baseline_fx_px_m = 0;      ///< 0: not a stereo camera
  int width_px = 0, height_px = 0;  ///< 0: as the images say
};

/// T_world_camera: takes points of the camera to the world.
struct Transform {
  double rotation[9];  ///< matrix, row-major
  double translation_m[3];

  Transform() : rotation{1, 0, 0, 0, 1, 0, 0, 0, 1}, translation_m() {}
};

/// One frame. Only keypoints are required; arrays are as long as they are, or empty. Nothing is copied by the
/// library but what its history keeps.
struct Frame {
  std::int64_t id = 0;  ///< grows from frame to frame
  double timestamp_s = 0;
  std::vector<cv::KeyPoint> keypoints;              ///< distorted pixels, with octave
  std::vector<cv::KeyPoint> keypoints_undistorted;  ///< empty: computed from the camera
  cv::Mat descriptors;                              ///< CV_8U, a row per keypoint
  std::vector<float> depth_m;                       ///< per keypoint; <= 0 or NaN: none
  std::vector<float> right_u_px;                    ///< stereo: column in the right image; < 0 or NaN: none
  cv::Mat grey;                                     ///< CV_8UC1
  cv::Mat right_grey;                               ///< stereo: the rectified right image, CV_8UC1
  cv::Mat depth;                                    ///< CV_32FC1 or CV_16UC1, same size
  double depth_unit_m = 1;                          ///< metres per unit of `depth`
  bool has_camera = false;
  Camera camera;
  PoseKind pose_kind = PoseKind::None;
  Transform T_world_camera;
  MotionKind motion_kind = MotionKind::None;  ///< what sensors beside the camera say of its motion ...
  std::int64_t motion_frame_id = -1;          ///< ... since this frame, -1: the one before
  Transform T_current_reference;              ///< takes points of the camera then to the camera now
  double motion_covariance[36] = {};          ///< as of dynfilter::MotionPrior, row-major
  std::vector<std::int64_t> map_point_ids;    ///< -1: none
  std::vector<cv::Point3f> map_points_world_m;
  bool has_boxes = false;  ///< true with no boxes: the detector found nothing
  std::vector<Box> boxes;
  std::int64_t boxes_frame_id = -1;  ///< the frame that they were computed on, -1: this one
  cv::Mat mask;                      ///< CV_8UC1, 0 = background; empty: none
  std::int64_t mask_frame_id = -1;
  bool has_matches = false;
  std::vector<std::int32_t> match_index;  ///< per keypoint its index in the frame below, -1: none
  std::int64_t match_frame_id = -1;
};

/// What the host's tracker made of a frame. What it does not say stays empty.
struct Tracking {
  std::vector<cv::KeyPoint> keypoints;      ///< as they were judged, without those that were rejected
  std::vector<std::int64_t> map_point_ids;  ///< of each of them; -1: none
  std::size_t inliers, outliers;            ///< matches that agree with its map, and that do not

  Tracking() : inliers(0), outliers(0) {}
};

/// Per feature, in the order of Frame::keypoints.
struct Verdicts {
  std::vector<std::uint8_t> keep;      ///< 0: on something that moves
  std::vector<std::int8_t> decision;   ///< 1 dynamic, 0 unknown (kept), -1 static
  std::vector<float> suspicion;        ///< [0, 1]; negative: no stage judged it
  std::vector<float> weight;           ///< [0, 1]: what an optimiser multiplies the information with
  std::vector<std::uint8_t> restored;  ///< 1: dynamic, but brought back by the floor
  std::vector<std::uint64_t> reasons;  ///< bit k: stages[k] called it dynamic
  std::vector<std::string> stages;
  std::vector<std::string> notes;  ///< of the frame: resets, floor, inputs that could not be used
  std::size_t rejected;
  bool wait_for_keyframe;  ///< before the first keyframe: wait with it
  double correspondence_ms, total_ms;

  Verdicts() : rejected(0), wait_for_keyframe(false), correspondence_ms(0), total_ms(0) {}
};

/// What one stage of the pipeline did with one frame.
struct StageReport {
  std::string name;  ///< of the filter or combinator
  std::string path;  ///< its place in the pipeline file
  bool skipped;      ///< an input was missing: see note
  bool failed;       ///< it threw: see note; its votes count as unknown
  std::string note;  ///< why it was skipped, which model was used, ...; "" if nothing
  std::size_t judged, dynamic, unknown;
  std::size_t prior;  ///< suspects that are kept out of the fit of models
  double time_ms;     ///< with the shared evidence that it was the first to use

  StageReport() : skipped(false), failed(false), judged(0), dynamic(0), unknown(0), prior(0), time_ms(0) {}
};

/// One camera stream, one thread. No function throws: false means that it failed, and error() says why.
class DYNFILTER_FACADE_API DynFilter {
 public:
  DynFilter() noexcept;
  ~DynFilter();
  DynFilter(DynFilter&& other) noexcept;
  DynFilter& operator=(DynFilter&& other) noexcept;
  DynFilter(const DynFilter&) = delete;
  DynFilter& operator=(const DynFilter&) = delete;

  /// A pipeline by its name ("dynfilter"), by the path of a file, or as YAML text.
  /// A line break or a `{` marks YAML text. Names are searched in the folders of the environment variable
  /// DYNFILTER_PRESETS, then in share/dynfilter/pipelines of the installation. error() lists the known names.
  bool load(const std::string& name_path_or_text) noexcept;
  /// A pipeline file, or any YAML file with a `pipeline` node in it. It replaces the present pipeline, but
  /// only if it can be used.
  bool load_file(const std::string& path) noexcept;
  /// YAML text; the present pipeline stays if it cannot be used.
  bool load_text(const std::string& yaml) noexcept;
  bool loaded() const noexcept;  ///< whether there is a pipeline

  /// Does what needs no keypoints of the next frame. May run in a thread beside the host's own work. It ends
  /// before the next call of this object. Verdicts stay the same.
  bool prepare(const cv::Mat& grey, double timestamp_s) noexcept;
  /// Judges one frame. False: see error().
  bool process(const Frame& frame, CallPoint call_point, Verdicts& verdicts) noexcept;
  /// Of the last frame that was processed: one entry per stage, in the order of Verdicts::stages.
  const std::vector<StageReport>& reports() const noexcept;
  /// A better pose of a frame that was judged before. `tracking` gives verdicts on map points, and lets the
  /// pipeline doubt itself where it rejects what the host's map agrees with.
  bool update_pose(std::int64_t frame_id, const Transform& T_world_camera, PoseKind kind,
                   const Tracking& tracking = Tracking()) noexcept;
  /// The host lost its pose: the poses of earlier frames are forgotten, the rest is kept.
  bool lost() noexcept;
  /// Map points that move, by the verdicts of all frames, sorted. From any thread.
  std::vector<std::int64_t> moved_map_points() const noexcept;
  /// Forgets all earlier frames.
  bool reset() noexcept;
  /// Writes each frame and verdict from now on to this file, of at most `max_mb` megabytes, for `dynfilter
  /// replay`. It ends with load() and with "". Replaces the file.
  bool record(const std::string& file, int max_mb = 4096) noexcept;

  /// Of the last call that failed.
  const std::string& error() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facade
}  // namespace dynfilter
