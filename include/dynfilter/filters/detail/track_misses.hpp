// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/filters/detail/judged_frame.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/motion/camera_path.hpp>
#include <dynfilter/motion/static_miss.hpp>
#include <vector>

namespace dynfilter::detail {

/// How far each feature misses the place of a static point: over the last step, and over its track.
class TrackMisses {
 public:
  struct Measured {
    int gap = 0;  ///< frames; 0: none
    SeenPoint then, now;
    StaticMiss miss;
    MatchSpread spread;
    bool in_space() const { return miss.axes == StaticMiss::Axes::Space; }
    bool on_line() const { return miss.axes == StaticMiss::Axes::Line; }
  };

  /// `depths`: noise of the frame's depths as measured.
  void measure(const JudgedFrame& frame, const CameraPath& path, const DepthNoise& depths) {
    step_.assign(frame.size(), {});
    track_.assign(frame.size(), {});
    unshared_.clear();
    set_noise(frame, path, depths, [&](std::size_t gap) { return path.noise_px(gap); });
    const Match& match = frame.match;
    const int most = static_cast<int>(std::min(path.unbroken(), path.steps()));
    for (std::size_t i = 0; i < frame.size(); ++i) {
      if (!match.found(i)) continue;
      step_[i] = measured(frame, path, i, 1, {match.reference_undistorted_px[i], match.reference_depth_m[i]},
                          match.correspondences.spread[i]);
      const int longest = std::min(frame.tracks.length(i), most);
      if (longest > 1 && frame.tracks.at(i, 1) == match.reference_undistorted_px[i])  // not looked at twice
        measure_track(frame, path, i, longest);
    }
  }
  /// The whole noise of a match, `sigma_px(gap)`, for model().
  template <class Sigma>
  void set_noise(const JudgedFrame& frame, const CameraPath& path, const DepthNoise& depths,
                 const Sigma& sigma_px) {
    models_.clear();
    for (std::size_t gap = 1; gap <= path.steps(); ++gap)
      models_.emplace_back(frame.camera, path.between(0, gap), RigidResidualNoise{sigma_px(gap), depths});
  }

  const Measured& step(std::size_t i) const { return step_[i]; }
  const Measured& track(std::size_t i) const { return track_[i]; }
  const StaticMissModel& model(int gap) const { return models_[static_cast<std::size_t>(gap - 1)]; }
  /// Of the tracks, with the noise that neighbours do not share.
  const std::vector<Miss>& of_tracks() const { return unshared_; }
  /// Per feature, whether it has no match, or one that misses by more than `most_px`.
  const std::vector<std::uint8_t>& doubted(double most_px) {
    doubted_.resize(step_.size());
    for (std::size_t i = 0; i < step_.size(); ++i)
      doubted_[i] = step_[i].gap > 0 && static_cast<double>(step_[i].miss.image_px) < most_px ? 0 : 1;
    return doubted_;
  }

  /// An error of the last frame's match: a mover misses more over its track.
  bool is_undone(std::size_t i) const {
    return step_[i].in_space() && track_[i].in_space() && track_[i].miss.image_px < step_[i].miss.image_px;
  }

 private:
  /// What misses with a depth at one end of a track only has a wrong depth nine times out of ten.
  void measure_track(const JudgedFrame& frame, const CameraPath& path, std::size_t i, int gap) {
    const Measured track = measured(
        frame, path, i, gap, {frame.tracks.at(i, gap), frame.tracks.depth_m(i, gap)}, frame.tracks.spread(i));
    if (!track.in_space()) return;
    track_[i] = track;
    unshared_.push_back({frame.evidence.pixels()[i], track.now.depth_m, track.miss.miss_px,
                         static_cast<float>(path.noise_px(static_cast<std::size_t>(gap)))});
  }
  Measured measured(const JudgedFrame& frame, const CameraPath& path, std::size_t i, int gap,
                    const SeenPoint& then, const MatchSpread& spread) const {
    const SeenPoint now = straightened(frame, path, i, gap);
    const StaticMiss miss = model(gap).miss(then, now);
    if (miss.axes == StaticMiss::Axes::None) return {};
    return {gap, then, now, miss, spread_of(spread, miss, path, gap)};
  }
  /// As all rows would have been seen at once, against the frame `gap` frames back.
  static SeenPoint straightened(const JudgedFrame& frame, const CameraPath& path, std::size_t i, int gap) {
    const SeenPoint seen{frame.evidence.undistorted_pixels()[i], frame.depth_m(i)};
    const RowTwist& twist = path.twist(static_cast<std::size_t>(gap));
    if (twist.none()) return seen;
    const Camera& c = frame.camera;
    const Eigen::Vector3d ray((seen.px.x - c.cx_px) / c.fx_px, (seen.px.y - c.cy_px) / c.fy_px, 1);
    const Eigen::Vector3d q = twist.straighten(ray, RowTwist::row(c, frame.evidence.pixels()[i].y));
    return {{static_cast<float>(c.fx_px * q.x() / q.z() + c.cx_px),
             static_cast<float>(c.fy_px * q.y() / q.z() + c.cy_px)},
            static_cast<float>(seen.depth_m * q.z())};
  }
  /// A long slide along an edge misses across it, too: the edge's direction is not exact.
  static MatchSpread spread_of(const MatchSpread& spread, const StaticMiss& miss, const CameraPath& path,
                               int gap) {
    MatchSpread out = spread;
    if (!spread.slides()) return out;
    const float off = MatchSpread::kEdgeTurn_rad * miss.miss_px.dot(spread.edge) /
                      static_cast<float>(path.noise_px(static_cast<std::size_t>(gap)));
    out.across += off * off;
    out.along = std::max(out.along, out.across);
    return out;
  }

  std::vector<Measured> step_, track_;  ///< per feature
  std::vector<Miss> unshared_;
  std::vector<std::uint8_t> doubted_;
  std::vector<StaticMissModel> models_;  ///< [g - 1]: over g frames
};

}  // namespace dynfilter::detail
