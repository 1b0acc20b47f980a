// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <type_traits>

#include "record_bytes.hpp"

/// The content of records. Each function writes a FrameView or a Verdict, and reads one that owns its memory.
namespace dynfilter::recorder {

/// Where an image is: in the record of images of a call.
struct ImagePlace {
  enum class Kind : std::uint8_t { None, Stored, LeftOut };
  Kind kind = Kind::None;
  std::uint64_t call = 0;  ///< Stored: the number of the call

  template <class Archive>
  void transfer(Archive& archive) {
    transfer_choice(archive, kind, 3);
    if (kind == Kind::Stored) archive.number(call);
  }
};

/// Images of a frame, by number: grey, depth, labels and the right one, then the masks of boxes.
inline constexpr std::uint32_t kGreySlot = 0, kDepthSlot = 1, kLabelSlot = 2, kRightSlot = 3,
                               kFirstBoxSlot = 4;

template <class Archive, class P>
void transfer_pose(Archive& archive, P& pose) {
  for (auto& value : pose.rotation) archive.number(value);
  for (auto& value : pose.translation_m) archive.number(value);
}

template <class Archive, class C>
void transfer_camera(Archive& archive, C& camera) {
  archive.number(camera.fx_px), archive.number(camera.fy_px);
  archive.number(camera.cx_px), archive.number(camera.cy_px);
  for (auto& value : camera.distortion) archive.number(value);
  archive.number(camera.baseline_fx_px_m);
  archive.number(camera.width_px), archive.number(camera.height_px);
}

template <class Archive, class Spread>
void transfer_spread(Archive& archive, Spread& spread) {
  archive.count(spread, sizeof(MatchSpread));
  for (auto& match : spread) {
    archive.number(match.edge.x), archive.number(match.edge.y);
    archive.number(match.along), archive.number(match.across), archive.number(match.depth_per_px);
  }
}

template <class Archive, class K>
void transfer_keyframe(Archive& archive, K& keyframe) {
  archive.number(keyframe.id);
  transfer_pose(archive, keyframe.T_world_camera);
  archive.array(keyframe.keypoints_undistorted);
  archive.array(keyframe.depth_m);
  archive.array(keyframe.map_point_ids);
}

template <class Archive, class D, class Images>
void transfer_detection(Archive& archive, D& detection, Images& images, std::uint32_t slot) {
  archive.number(detection.box.x), archive.number(detection.box.y);
  archive.number(detection.box.width), archive.number(detection.box.height);
  archive.number(detection.class_id), archive.number(detection.score), archive.number(detection.track_id);
  archive.text(detection.class_name);
  images.transfer(archive, slot, detection.mask);
}

/// Fewest bytes of a keyframe, a detection and a stage's report.
inline constexpr std::size_t kKeyframeBytes = 128, kDetectionBytes = 37, kStageBytes = 66;

/// `images` writes or finds each image: transfer(archive, slot, image).
template <class Archive, class Frame, class Images>
void transfer_frame(Archive& archive, Frame& frame, Images& images) {
  archive.number(frame.id), archive.number(frame.timestamp_s);
  archive.array(frame.keypoints), archive.array(frame.keypoints_undistorted);
  archive.matrix(frame.descriptors);
  archive.array(frame.depth_m), archive.array(frame.right_u_px);
  images.transfer(archive, kGreySlot, frame.grey);
  images.transfer(archive, kRightSlot, frame.right_grey);
  images.transfer(archive, kDepthSlot, frame.depth);
  archive.number(frame.depth_unit_m), archive.number(frame.depth_handed_over);
  transfer_optional(archive, frame.camera, [&](auto& camera) { transfer_camera(archive, camera); });
  transfer_pose(archive, frame.T_world_camera);
  transfer_choice(archive, frame.pose_provenance, 4);
  transfer_optional(archive, frame.motion_prior, [&](auto& prior) {
    archive.number(prior.reference_frame_id);
    transfer_pose(archive, prior.T_current_reference);
    for (auto& value : prior.covariance) archive.number(value);
    archive.number(prior.has_translation);
  });
  archive.array(frame.map_point_ids), archive.array(frame.map_points_world_m);
  archive.count(frame.covisible_keyframes, kKeyframeBytes);
  for (auto& keyframe : frame.covisible_keyframes) transfer_keyframe(archive, keyframe);
  transfer_optional(archive, frame.matches, [&](auto& matches) {
    archive.number(matches.reference_frame_id);
    archive.array(matches.reference_index);
    transfer_spread(archive, matches.spread);
  });
  transfer_optional(archive, frame.detections, [&](auto& boxes) {
    archive.number(boxes.frame_id);
    archive.count(boxes.detections, kDetectionBytes);
    std::uint32_t slot = kFirstBoxSlot;
    for (auto& detection : boxes.detections) transfer_detection(archive, detection, images, slot++);
  });
  transfer_optional(archive, frame.mask, [&](auto& mask) {
    archive.number(mask.frame_id);
    images.transfer(archive, kLabelSlot, mask.labels);
  });
}

template <class Archive, class Count>
void transfer_count(Archive& archive, Count& count) {
  std::uint64_t number = count;
  archive.number(number);
  if constexpr (Archive::kReads) count = static_cast<std::size_t>(number);
}

template <class Archive, class T>
void transfer_tracking(Archive& archive, T& tracking) {
  archive.array(tracking.keypoints), archive.array(tracking.map_point_ids);
  transfer_count(archive, tracking.inliers), transfer_count(archive, tracking.outliers);
}

template <class Archive, class S>
void transfer_stage(Archive& archive, S& stage) {
  archive.text(stage.name), archive.text(stage.path), archive.text(stage.note);
  archive.number(stage.skipped), archive.number(stage.failed);
  transfer_count(archive, stage.judged), transfer_count(archive, stage.dynamic);
  transfer_count(archive, stage.unknown), transfer_count(archive, stage.prior);
  archive.number(stage.time_ms);
}

template <class Archive, class R>
void transfer_report(Archive& archive, R& report) {
  archive.number(report.frame_id);
  transfer_choice(archive, report.call_point, 3);
  archive.count(report.stages, kStageBytes);
  for (auto& stage : report.stages) transfer_stage(archive, stage);
  archive.count(report.notes, sizeof(std::uint64_t));
  for (auto& note : report.notes) archive.text(note);
  transfer_count(archive, report.features), transfer_count(archive, report.rejected);
  transfer_count(archive, report.restored), transfer_count(archive, report.doubts);
  archive.number(report.wait_for_keyframe);
  archive.number(report.correspondence_ms), archive.number(report.total_ms);
}

template <class Archive, class V>
void transfer_verdict(Archive& archive, V& verdict) {
  archive.array(verdict.decision);
  archive.array(verdict.suspicion), archive.array(verdict.prior);
  archive.array(verdict.restored), archive.array(verdict.reasons);
  transfer_spread(archive, verdict.spread);
  archive.count(verdict.map_points, sizeof(std::int64_t) + 1 + sizeof(float));
  for (auto& point : verdict.map_points) {
    archive.number(point.map_point_id);
    transfer_choice(archive, point.vote, 3);
    archive.number(point.suspicion);
  }
  transfer_report(archive, verdict.report);
  if constexpr (Archive::kReads) {
    const std::size_t n = verdict.decision.size();
    if (verdict.suspicion.size() != n || verdict.prior.size() != n || verdict.restored.size() != n ||
        verdict.reasons.size() != n)
      ByteReader::fail();
    for (const Vote vote : verdict.decision)
      if (static_cast<std::uint8_t>(vote) > static_cast<std::uint8_t>(Vote::Dynamic)) ByteReader::fail();
  }
}

template <class Archive, class H>
void transfer_head(Archive& archive, H& head) {
  archive.text(head.library), archive.text(head.name), archive.text(head.yaml);
  archive.count(head.parameters, 2 * sizeof(std::uint64_t));
  for (auto& [name, value] : head.parameters) archive.text(name), archive.text(value);
}

}  // namespace dynfilter::recorder
