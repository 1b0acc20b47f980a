// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/static_map.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/pose_lookup.hpp"
#include "io/sequence.hpp"
#include "io/trajectory.hpp"
#include "map_output.hpp"
#include "render/map_truth.hpp"
#include "render/scene_file.hpp"

namespace dynfilter::command {

/// Evaluates the map of a rendered sequence against the exact surfaces of its scene.
class MapJudge {
 public:
  /// Throws IoError if the sequence does not name its scene, or names another one.
  MapJudge(const io::Sequence& sequence, const mapping::MappingParams& params)
      : sequence_(&sequence),
        truth_(scene_of(sequence)),
        poses_(truth_poses(sequence)),
        oracle_(oracle_params(params)) {
    const double first_s = sequence.timestamp_s(0);
    const std::optional<Pose> pose = poses_.at(first_s);
    if (!pose || truth_.distance_from(first_s, *pose) > 0.01)
      throw IoError((sequence.folder() / "scene.txt").string() +
                    ": the camera of that scene is elsewhere than groundtruth.txt says");
  }

  /// Call with every frame that has depth.
  void see(std::size_t index, const io::SequenceFrame& frame) {
    const std::optional<Pose> pose = poses_.at(sequence_->timestamp_s(index));
    if (!pose || frames_++ % kStep != 0) return;
    truth_.see(frame.depth, frame.depth_unit_m, sequence_->load_labels(index), sequence_->camera(), *pose);
  }

  /// Call with every keyframe of the map.
  void add_keyframe(const MapInput& input) {
    const double stamp_s = sequence_->timestamp_s(input.index);
    stamps_s_.push_back(stamp_s);
    const std::optional<Pose> pose = poses_.at(stamp_s);
    if (!pose) return;
    mapping::MapFrame frame = input.frame;
    frame.T_world_camera = *pose;
    frame.moving_mask = sequence_->load_labels(input.index);
    oracle_.add(frame);
  }

  /// `estimate`: poses that the map was built with. They are aligned with the truth.
  /// `sources`: keyframes of the points. Where these are unknown, any keyframe may be the source.
  MapTruthSummary judge(const mapping::MapCloud& cloud, const mapping::MapSources& sources,
                        const io::Trajectory& estimate) {
    MapTruthSummary result;
    const std::optional<Pose> T = io::align_poses(*sequence_->ground_truth(), estimate);
    if (!T) return result;
    const Eigen::Isometry3d T_truth_map = T->isometry();
    std::vector<cv::Point3f> points;
    for (const cv::Point3f& p : cloud.points_m) {
      const Eigen::Vector3d q = T_truth_map * Eigen::Vector3d(p.x, p.y, p.z);
      points.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()));
    }
    const render::MapQuality ours = truth_.judge(points, [&](std::size_t i) {
      return sources.complete ? sources.stamps_s(i) : Span<const double>(stamps_s_);
    });
    const render::MapQuality oracle =
        truth_.judge(oracle_.cloud().points_m, [&](std::size_t) { return Span<const double>(stamps_s_); });
    result.ghosts = ours.ghost_share(), result.astray = ours.astray_share();
    result.coverage = ours.coverage(), result.oracle_coverage = oracle.coverage();
    result.error_median_m = ours.error_median_m, result.error_p95_m = ours.error_p95_m;
    return result;
  }

 private:
  /// Visible surface is computed from every kStep-th frame.
  static constexpr std::size_t kStep = 4;

  static render::MapTruth scene_of(const io::Sequence& sequence) {
    const std::optional<render::SceneName> name = render::read_scene_name(sequence.folder());
    if (!name || !sequence.has_labels())
      throw IoError(sequence.folder().string() +
                    ": has no scene.txt and labels/; --truth needs a sequence that synth wrote");
    return render::MapTruth(name->scene, name->seed);
  }
  static io::PoseLookup truth_poses(const io::Sequence& sequence) {
    std::optional<io::Trajectory> truth = sequence.ground_truth();
    if (!truth) throw IoError(sequence.folder().string() + ": has no groundtruth.txt, which --truth needs");
    return io::PoseLookup(std::move(*truth));
  }
  static mapping::MappingParams oracle_params(mapping::MappingParams params) {
    params.cut.boxes = mapping::BoxCut::Ignore;
    return params;
  }

  const io::Sequence* sequence_;
  render::MapTruth truth_;
  io::PoseLookup poses_;
  mapping::StaticMap oracle_;
  std::vector<double> stamps_s_;
  std::size_t frames_ = 0;
};

}  // namespace dynfilter::command
