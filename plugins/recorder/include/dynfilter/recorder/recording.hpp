// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::recorder {

/// Of the format. Readers refuse every other one.
inline constexpr std::uint32_t kVersion = 3;

/// A KeyframeView that owns its memory.
struct RecordedKeyframe {
  std::int64_t id = -1;
  Pose T_world_camera;
  std::vector<cv::KeyPoint> keypoints_undistorted;
  std::vector<float> depth_m;
  std::vector<std::int64_t> map_point_ids;
};
/// HostMatches that own their memory.
struct RecordedMatches {
  std::int64_t reference_frame_id = -1;
  std::vector<std::int32_t> reference_index;
  std::vector<MatchSpread> spread;
};
/// A DetectionInput that owns its memory.
struct RecordedDetections {
  std::int64_t frame_id = -1;
  std::vector<Detection> detections;
};

/// A FrameView that owns its memory. Members have the view's names.
struct RecordedFrame {
  std::int64_t id = 0;
  double timestamp_s = 0;
  std::vector<cv::KeyPoint> keypoints, keypoints_undistorted;
  cv::Mat descriptors;
  std::vector<float> depth_m, right_u_px;
  cv::Mat grey, right_grey, depth;
  double depth_unit_m = 1;
  bool depth_handed_over = false;
  std::optional<Camera> camera;
  Pose T_world_camera;
  PoseProvenance pose_provenance = PoseProvenance::None;
  std::optional<MotionPrior> motion_prior;
  std::vector<std::int64_t> map_point_ids;
  std::vector<cv::Point3f> map_points_world_m;
  std::vector<RecordedKeyframe> covisible_keyframes;
  std::optional<RecordedMatches> matches;
  std::optional<RecordedDetections> detections;
  std::optional<MaskInput> mask;
  std::size_t images_left_out = 0;  ///< images of the host that the recording does not have

  /// Valid while this frame and `keyframes` exist, which it fills.
  FrameView view(std::vector<KeyframeView>& keyframes) const;
};

/// A HostTracking that owns its memory.
struct RecordedTracking {
  std::vector<cv::KeyPoint> keypoints;
  std::vector<std::int64_t> map_point_ids;
  std::size_t inliers = 0, outliers = 0;

  /// Valid while this exists.
  HostTracking view() const { return {keypoints, map_point_ids, inliers, outliers}; }
};

/// What the host did, in its order.
struct RecordedEvent {
  /// Which of the host's calls it was.
  enum class Kind { Frame, Pose, Reset, Lost };
  Kind kind = Kind::Frame;
  // Frame: a call of the pipeline.
  RecordedFrame frame;
  CallPoint point = CallPoint::BeforePose;
  HostLimits limits;
  std::optional<Verdict> verdict;  ///< none: the program ended while the frame was judged
  // Pose: Pipeline::update_pose().
  std::int64_t pose_frame_id = -1;
  Pose T_world_camera;
  PoseProvenance provenance = PoseProvenance::None;
  RecordedTracking tracking;

  /// Calls reset(), lost() or update_pose(). Nothing for a frame.
  void repeat(Pipeline& pipeline) const;
};

/// The pipeline of a recording.
struct RecordedPipeline {
  std::string library, name;  ///< version of dynfilter; name of the pipeline
  std::string yaml;           ///< "": it was made in code
  /// Each parameter outside of the stages and its value, which code may have changed.
  std::vector<std::pair<std::string, std::string>> parameters;
};

/// The pipeline as it was recorded. Throws ConfigError, also for one that was made in code.
PipelineConfig config_of(const RecordedPipeline& recorded, const Registry& registry);

/// How far two verdicts on one frame differ. Times are not compared.
struct VerdictDifference {
  std::size_t decisions = 0;  ///< features with another decision, or that one verdict lacks
  std::size_t features = 0;   ///< features of which any bit differs, those included
  bool report = false;        ///< verdicts on map points, notes, counts, or wait_for_keyframe differ

  /// Whether anything differs.
  bool any() const { return features > 0 || report; }
};
/// Compares two verdicts bit for bit.
VerdictDifference difference(const Verdict& a, const Verdict& b);

/// Reads a recording from front to back. Allocates no more than its records hold: what a record claims is
/// checked against its bytes first. LZ4 expands 255 times at most.
class RecordingReader {
 public:
  /// Reads where the records are. Throws IoError for what is no recording, or of another version. A file that
  /// was cut off is read up to there, and notes() says so.
  explicit RecordingReader(const std::filesystem::path& file);
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;

  const RecordedPipeline& pipeline() const;       ///< that judged the frames
  std::size_t calls() const;                      ///< frames handed to the pipeline, at all call points
  const std::vector<std::string>& notes() const;  ///< how the recording ended; what it lacks
  /// The next event; nullopt at the end. Throws IoError where the file is damaged.
  std::optional<RecordedEvent> next();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynfilter::recorder
