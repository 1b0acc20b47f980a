// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace dynfilter {

/// Whether a pipeline rejects the static scene. The host's tracking is the evidence against it.
///
/// A frame counts if more than 30 % of its judged features are dynamic, and most of the host's matches are
/// inliers of its map. The dynamic features must follow the host's motion as closely as the static ones do.
/// Those of movers do not, so a crowd does not count. Features that a detector suspects are left out. Needs
/// depth and estimated poses. Frames that count for half a second without a gap give a doubt.
class SelfCheck {
 public:
  /// Of a call before the pose, before the evidence ends. Costs nothing unless the host tells its inliers.
  /// `semantic`, bit k: stage k rejects what a detector found, whether or not it moves.
  void keep(const FrameEvidence& evidence, const Verdict& verdict, std::uint64_t semantic);
  /// The host's result on a frame, whose pose the evidence has. True: doubt.
  bool doubts(const FrameEvidence& evidence, std::int64_t frame_id, const HostTracking& tracking);
  void reset() { judged_.clear(), since_s_.reset(); }

 private:
  static constexpr double kMuch = 0.3;  ///< share of the judged features
  static constexpr double kAgrees =
      0.7;  ///< share of the host's matches; ORB-SLAM's inliers are 75 % and more
  static constexpr std::size_t kLeastMatches = 30;  ///< with which ORB-SLAM goes on tracking
  static constexpr std::size_t kLeastDynamic = 20;  ///< whose median means something
  static constexpr float kAsClosely = 2;            ///< ratio of the medians of residuals
  static constexpr float kExact_px = 0.5F;          ///< a residual that is noise in any case
  static constexpr double kTime_s = 0.45;           ///< from the first to the last of 15 frames at 30 Hz
  static constexpr int kLeastFrames = 5;            ///< within that time, for slow cameras

  struct Judged {
    cv::Point3f now_m;
    cv::Point2f then_px;
    bool dynamic;
  };
  bool counts(const PastFrame& now, const PastFrame& then, const HostTracking& tracking);

  std::int64_t now_id_ = -1, then_id_ = -1;
  std::vector<Judged> judged_;
  bool rejects_much_ = false, host_tells_ = false, told_ = false;
  std::optional<double> since_s_;  ///< stamp of the first frame that counts
  int frames_ = 0;                 ///< that count, since then
  std::vector<float> dynamic_px_, static_px_;
};

inline void SelfCheck::keep(const FrameEvidence& evidence, const Verdict& verdict, std::uint64_t semantic) {
  if (!std::exchange(told_, false)) since_s_.reset();
  judged_.clear();
  if (!host_tells_ || evidence.spread() == nullptr) return;
  const Match& match = evidence.match({});
  now_id_ = evidence.frame().id, then_id_ = match.reference->id;
  std::size_t dynamic = 0, all = 0;
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    const bool moves = verdict.called_dynamic(i);
    if (!moves && verdict.decision[i] == Vote::Unknown) continue;
    if (verdict.prior[i] != 0 || (verdict.reasons[i] & semantic) != 0) continue;
    ++all, dynamic += moves ? 1 : 0;
    const cv::Point3f& point_m = evidence.points_m()[i];
    if (match.found(i) && std::isfinite(point_m.z))
      judged_.push_back({point_m, match.reference_undistorted_px[i], moves});
  }
  rejects_much_ = static_cast<double>(dynamic) > kMuch * static_cast<double>(all);
}

inline bool SelfCheck::doubts(const FrameEvidence& evidence, std::int64_t frame_id,
                              const HostTracking& tracking) {
  host_tells_ = host_tells_ || tracking.inliers > 0;
  if (judged_.empty() || frame_id != now_id_ || told_) return false;
  const PastFrame *now = evidence.kept_frame(frame_id), *then = evidence.kept_frame(then_id_);
  told_ = now != nullptr && then != nullptr && counts(*now, *then, tracking);
  if (!told_) return false;
  if (!since_s_) since_s_ = now->timestamp_s, frames_ = 0;
  return ++frames_ >= kLeastFrames && now->timestamp_s - *since_s_ >= kTime_s;
}

inline bool SelfCheck::counts(const PastFrame& now, const PastFrame& then, const HostTracking& tracking) {
  const auto estimated = [](const PastFrame& f) { return f.pose_provenance >= PoseProvenance::Estimated; };
  const std::size_t matches = tracking.inliers + tracking.outliers;
  if (!rejects_much_ || matches < kLeastMatches || !estimated(now) || !estimated(then) || !then.camera ||
      static_cast<double>(tracking.inliers) < kAgrees * static_cast<double>(matches))
    return false;
  const Pose T_then_now = inverse(then.T_world_camera) * now.T_world_camera;
  const PointMotion to_then(T_then_now);
  dynamic_px_.clear(), static_px_.clear();
  for (const Judged& judged : judged_) {
    const cv::Point2f miss = project(*then.camera, to_then(judged.now_m)) - judged.then_px;
    (judged.dynamic ? dynamic_px_ : static_px_).push_back(portable::hypot(miss.x, miss.y));
  }
  if (dynamic_px_.size() < kLeastDynamic) return false;
  const float usual_px = static_px_.empty() ? 0 : median_in_place(static_px_);
  return median_in_place(dynamic_px_) <= std::max(kExact_px, kAsClosely * usual_px);
}

}  // namespace dynfilter
