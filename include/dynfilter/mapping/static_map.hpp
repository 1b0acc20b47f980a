// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/depth_cut.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/depth_view.hpp>
#include <dynfilter/mapping/key_regions.hpp>
#include <dynfilter/mapping/map_cloud.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/registration.hpp>
#include <dynfilter/mapping/shown_voxels.hpp>
#include <dynfilter/mapping/voxel_grid.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::mapping {

/// Content of a map.
struct MapState {
  /// On the coarse and on the fine grid, hidden voxels included.
  std::size_t voxels = 0, key_voxels = 0;
  double leaf_m = 0, key_leaf_m = 0;  ///< current values; leaves double when the map is full
  std::size_t keyframes = 0, permanent_keyframes = 0;
  std::size_t voxel_bytes = 0, keyframe_bytes = 0;
};

/// The dense map of the static scene, built from keyframes (RTS-SLAM sec. 3.5). Moving pixels are removed
/// from each keyframe's depth image (DepthCut). The rest becomes a cloud of voxel centroids in the camera
/// frame. The cloud is transformed by the pose and added to the world's voxels as integers. A keyframe can
/// therefore be removed or moved later. The map is then bit for bit as if the keyframe had never been added,
/// or had this pose.
///
/// Free space removes what a mask missed.
/// Each voxel counts how many keyframes see a surface there and how many see through it (DepthView, Carving),
/// regardless of their order. A person who left is hidden once enough keyframes see the wall behind.
/// A new object in free space is added only after enough keyframes see it.
///
/// Memory is bounded. The map holds at most max_voxels; when it is full, leaves double. Keyframe clouds and
/// views take at most max_keyframe_mb. Beyond that, the oldest keyframes become permanent. They remain in the
/// map, but can no longer be removed or moved. Not thread-safe; see mapping_thread.hpp.
class StaticMap {
 public:
  /// Throws ConfigError if a parameter is out of range.
  explicit StaticMap(const MappingParams& params = MappingParams());

  /// Fuses a keyframe. An unusable keyframe changes nothing; report.note gives the reason.
  MapReport add(const MapFrame& frame);

  /// Adds key regions of any other frame (Algorithm 2). Call it in order of time.
  /// Within key_window frames of a keyframe, before or after it, they refine that keyframe.
  /// They move with it. Frames without detections of key classes cost almost nothing.
  MapReport observe(const MapFrame& frame);

  /// Removes a keyframe. The map is then as if it had never been added. False if it is unknown or permanent.
  bool remove(std::int64_t id);

  /// Moves a keyframe to another pose, for example after loop closure, without alignment.
  /// False, without effect, if it is unknown or permanent or the pose is not rigid.
  bool move(std::int64_t id, const Pose& T_world_camera);

  /// The map as points, sorted by class and position. Equal maps give equal clouds. Excludes voxels that were
  /// seen through and isolated voxels. Excludes coarse voxels where fine voxels of key objects exist.
  MapCloud cloud() const;

  /// The keyframes that contribute to each point of cloud(). A neighbour's points count as those of its
  /// keyframe. Recomputed from the keyframes' clouds, in about the time of their fusion.
  MapSources sources() const;

  MapState state() const;  ///< sizes and counts
  const MappingParams& params() const { return params_; }
  const VoxelMap& voxels() const { return map_; }          ///< those of ordinary surfaces
  const VoxelMap& key_voxels() const { return key_map_; }  ///< those of key objects, which are finer
  double leaf_m() const { return params_.leaf_m * std::ldexp(1.0, map_.level()); }  ///< width of a voxel [m]
  /// Width of a voxel of key objects [m].
  double key_leaf_m() const {
    return params_.leaf_m / params_.key_divisor * std::ldexp(1.0, key_map_.level());
  }

  /// Doubles all leaves. This happens automatically when the map is full.
  void double_leaf();

 private:
  struct Keyframe {
    std::int64_t id = -1;
    double timestamp_s = 0;
    Pose T_world_camera, T_given;              ///< T_given: before alignment with the map
    std::vector<VoxelPoint> cloud, key_cloud;  ///< camera frame
    DepthView view;
  };
  struct Neighbour {
    std::int64_t number;
    Pose T_world_camera;
    std::vector<VoxelPoint> cloud;
  };

  double unit_m() const { return params_.leaf_m / (1 << VoxelMap::kLeafBits); }
  double key_unit_m() const { return unit_m() / params_.key_divisor; }
  static std::size_t bytes_of(const Keyframe& k) {
    return sizeof(Keyframe) + (k.cloud.capacity() + k.key_cloud.size()) * sizeof(VoxelPoint) + k.view.bytes();
  }
  Keyframe* find(std::int64_t id) {
    for (const auto& keyframe : keyframes_)
      if (keyframe->id == id) return keyframe.get();
    return nullptr;
  }
  static std::string skip_reason(const MapFrame& frame);

  /// Depths in metres, 0: no depth.
  /// Depths beyond max_depth_m are kept, because they prove free space in front of them.
  void read_depth(const MapFrame& frame);
  DepthSource source(const MapFrame& frame, const cv::Mat& usable) const;
  void fuse(const MapFrame& frame, MapReport& report);
  void align(Keyframe& keyframe, MapReport& report);

  /// Also computes the rest of the image, key_regions_.outside().
  void cloud_of_key_regions(const MapFrame& frame, std::vector<VoxelPoint>& cloud, MapReport& report);

  /// Stores a neighbour's points in the keyframe's camera frame, so that they move with it.
  static void append_in(Keyframe& keyframe, const Neighbour& neighbour);

  void put_in(Keyframe& keyframe);
  void take_out(Keyframe& keyframe) {
    fuse_points(map_, unit_m(), keyframe.cloud, 0, keyframe.T_world_camera, -1);
    fuse_points(key_map_, key_unit_m(), keyframe.key_cloud, 0, keyframe.T_world_camera, -1);
    if (params_.carve.enabled) vote(keyframe, 0, 0, -1);
  }

  /// Sign 1 adds, -1 removes.
  void fuse_points(VoxelMap& map, double unit_m, const std::vector<VoxelPoint>& cloud, std::size_t begin,
                   const Pose& T, int sign) {
    outside_ += to_world(cloud, begin, T, unit_m, world_);
    sign > 0 ? map.add(world_.data(), world_.size()) : map.subtract(world_.data(), world_.size());
  }
  /// Converts points to quanta of the map. Returns how many are out of range.
  /// noinline: all callers must compute identical results.
  static std::size_t to_world(const std::vector<VoxelPoint>& cloud, std::size_t begin, const Pose& T,
                              double unit_m, std::vector<WorldPoint>& world);

  /// Adds a keyframe's votes on the voxels from these indices.
  void vote(const Keyframe& keyframe, std::size_t begin, std::size_t key_begin, int sign) {
    const Pose& T = keyframe.T_world_camera;
    add_votes(map_, keyframe.view, T, begin, leaf_m(), sign);
    add_votes(key_map_, keyframe.view, T, key_begin, key_leaf_m(), sign);
  }
  void vote_on_new(VoxelMap& map, std::size_t begin, double leaf_m) {
    if (!params_.carve.enabled) return;
    for (const auto& keyframe : keyframes_)
      add_votes(map, keyframe->view, keyframe->T_world_camera, begin, leaf_m, 1);
  }
  void make_room(MapReport& report);

  static constexpr float kFarthestM = 65;              ///< range of DepthView
  static constexpr std::size_t kMaxKeyframes = 60000;  ///< Votes count up to 65535.

  MappingParams params_;
  DepthCut cut_;
  VoxelGrid grid_, key_grid_;
  KeyRegions key_regions_;
  MapRegistration registration_;
  PixelRays rays_;
  cv::Mat depth_m_;
  VoxelMap map_, key_map_;
  std::deque<std::unique_ptr<Keyframe>> keyframes_;
  std::deque<Neighbour> neighbours_;
  std::vector<VoxelPoint> cloud_;
  std::vector<WorldPoint> world_;
  std::size_t outside_ = 0, permanent_ = 0, keyframe_bytes_ = 0;
  std::int64_t last_added_ = -1, frames_seen_ = 0, frames_since_key_ = 0;
};

inline StaticMap::StaticMap(const MappingParams& params)
    : params_((check_mapping(params), params)),
      cut_(params.cut),
      grid_(params.leaf_m),
      key_grid_(params.leaf_m / params.key_divisor),
      key_regions_(params.key_classes),
      registration_(params.registration) {}

inline MapReport StaticMap::add(const MapFrame& frame) {
  const auto start = std::chrono::steady_clock::now();
  MapReport report;
  report.T_world_camera = frame.T_world_camera;
  report.note = skip_reason(frame);
  if (report.note.empty() && find(frame.id) != nullptr)
    report.note = "the map already has a keyframe with this id";
  if (report.note.empty()) {
    fuse(frame, report);
    report.used = true;
  }
  report.time_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return report;
}

inline MapReport StaticMap::observe(const MapFrame& frame) {
  MapReport report;
  report.T_world_camera = frame.T_world_camera;
  ++frames_since_key_;
  if (params_.key_window == 0 || !key_regions_.any(frame.detections)) return report;
  report.note = skip_reason(frame);
  if (!report.note.empty()) return report;
  read_depth(frame);
  Neighbour neighbour{frames_seen_ + frames_since_key_, frame.T_world_camera, {}};
  cloud_of_key_regions(frame, neighbour.cloud, report);
  report.used = true;
  Keyframe* last = keyframes_.empty() ? nullptr : keyframes_.back().get();
  if (last != nullptr && frames_since_key_ <= params_.key_window && last->id == last_added_) {
    const std::size_t before = last->key_cloud.size();
    append_in(*last, neighbour);
    const std::size_t known = key_map_.size();
    fuse_points(key_map_, key_unit_m(), last->key_cloud, before, last->T_world_camera, 1);
    vote_on_new(key_map_, known, key_leaf_m());
    keyframe_bytes_ += (last->key_cloud.size() - before) * sizeof(VoxelPoint);
    make_room(report);
  }
  neighbours_.push_back(std::move(neighbour));
  while (neighbours_.size() > static_cast<std::size_t>(params_.key_window)) neighbours_.pop_front();
  return report;
}

inline bool StaticMap::remove(std::int64_t id) {
  const auto at =
      std::find_if(keyframes_.begin(), keyframes_.end(), [&](const auto& k) { return k->id == id; });
  if (at == keyframes_.end()) return false;
  take_out(**at);
  keyframe_bytes_ -= bytes_of(**at);
  keyframes_.erase(at);
  return true;
}

inline bool StaticMap::move(std::int64_t id, const Pose& T_world_camera) {
  Keyframe* keyframe = find(id);
  if (keyframe == nullptr || !is_rigid(T_world_camera)) return false;
  take_out(*keyframe);
  keyframe->T_world_camera = keyframe->T_given = T_world_camera;
  put_in(*keyframe);
  return true;
}

inline MapCloud StaticMap::cloud() const {
  MapCloud cloud;
  const ShownVoxels shown = shown_voxels(map_, key_map_, params_);
  append_cloud(key_map_, shown.fine, key_unit_m(), cloud);
  append_cloud(map_, shown.coarse, unit_m(), cloud);
  return cloud;
}

inline MapSources StaticMap::sources() const {
  const ShownVoxels shown = shown_voxels(map_, key_map_, params_);
  const auto fine = SourceCollector::places(key_map_, shown.fine, 0),
             coarse = SourceCollector::places(map_, shown.coarse, shown.fine.size());
  SourceCollector collector;
  std::vector<WorldPoint> world;
  for (std::uint32_t k = 0; k < keyframes_.size(); ++k) {
    const Keyframe& keyframe = *keyframes_[k];
    to_world(keyframe.key_cloud, 0, keyframe.T_world_camera, key_unit_m(), world);
    collector.add(key_map_, fine, world, k);
    to_world(keyframe.cloud, 0, keyframe.T_world_camera, unit_m(), world);
    collector.add(map_, coarse, world, k);
  }
  MapSources sources = collector.finish(
      shown.fine.size() + shown.coarse.size(), [&](std::size_t k) { return keyframes_[k]->id; },
      [&](std::size_t k) { return keyframes_[k]->timestamp_s; });
  sources.complete = permanent_ == 0;
  return sources;
}

inline MapState StaticMap::state() const {
  return {map_.size(),
          key_map_.size(),
          leaf_m(),
          key_leaf_m(),
          keyframes_.size(),
          permanent_,
          map_.bytes() + key_map_.bytes(),
          keyframe_bytes_};
}

inline void StaticMap::double_leaf() {
  map_.coarsen();
  key_map_.coarsen();
  if (!params_.carve.enabled) return;
  for (const auto& keyframe : keyframes_) vote(*keyframe, 0, 0, 1);
}

inline std::string StaticMap::skip_reason(const MapFrame& frame) {
  if (frame.depth.empty()) return "no depth image";
  if (frame.depth.type() != CV_16UC1 && frame.depth.type() != CV_32FC1)
    return "the depth image is neither CV_16UC1 nor CV_32FC1";
  if (!(frame.depth_unit_m > 0 && std::isfinite(frame.depth_unit_m))) return "depth_unit_m is not above 0";
  if (!frame.camera.valid()) return "no camera";
  const bool other_size = frame.camera.width_px > 0 && frame.camera.height_px > 0 &&
                          frame.depth.size() != cv::Size(frame.camera.width_px, frame.camera.height_px);
  if (other_size) return "the depth image is not of the camera's size";
  if (!is_rigid(frame.T_world_camera)) return "the pose is not rigid";
  return {};
}

inline void StaticMap::read_depth(const MapFrame& frame) {
  rays_.set(frame.camera, frame.depth.size());
  depth_m_.create(frame.depth.size(), CV_32FC1);
  const DepthRange range{static_cast<float>(params_.min_depth_m), kFarthestM};
  const auto unit = static_cast<float>(frame.depth_unit_m);
  for (int y = 0; y < depth_m_.rows; ++y)
    detail::read_depths(frame.depth, y, 0, depth_m_.cols, unit, range, depth_m_.ptr<float>(y));
  cut_.run(depth_m_, frame, static_cast<float>(params_.max_depth_m));
}

inline DepthSource StaticMap::source(const MapFrame& frame, const cv::Mat& usable) const {
  DepthSource s;
  s.depth = depth_m_;
  s.range = {1e-6F, static_cast<float>(params_.max_depth_m)};
  s.rays = &rays_;
  s.bgr = frame.bgr;
  s.usable = usable;
  s.labels = frame.classes;
  return s;
}

inline void StaticMap::fuse(const MapFrame& frame, MapReport& report) {
  read_depth(frame);
  report.pixels = cut_.pixels();
  report.cut_pixels = cut_.cut_pixels();
  report.edge_pixels = cut_.edge_pixels();
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->id = frame.id;
  keyframe->timestamp_s = frame.timestamp_s;
  keyframe->T_world_camera = keyframe->T_given = frame.T_world_camera;
  cloud_of_key_regions(frame, keyframe->key_cloud, report);
  grid_.run(source(frame, key_regions_.outside()), cloud_);
  report.outside += grid_.outside();
  keyframe->cloud.assign(cloud_.begin(), cloud_.end());
  for (const Neighbour& neighbour : neighbours_)
    if (frames_seen_ + frames_since_key_ + 1 - neighbour.number <= params_.key_window)
      append_in(*keyframe, neighbour);
  keyframe->view.build(depth_m_, cut_.moving(), frame.camera);
  align(*keyframe, report);
  report.points = keyframe->cloud.size();
  report.key_points = keyframe->key_cloud.size();
  const std::size_t before = map_.size() + key_map_.size();
  put_in(*keyframe);
  report.new_voxels = map_.size() + key_map_.size() - before;
  report.outside += outside_;
  last_added_ = frame.id;
  frames_seen_ += frames_since_key_ + 1;
  frames_since_key_ = 0;
  keyframe_bytes_ += bytes_of(*keyframe);
  keyframes_.push_back(std::move(keyframe));
  make_room(report);
}

inline void StaticMap::align(Keyframe& keyframe, MapReport& report) {
  if (!params_.registration.enabled) return;
  const std::optional<Pose> corrected =
      registration_.run(map_, unit_m(), keyframe.cloud, keyframe.T_world_camera);
  if (!corrected) return;
  keyframe.T_world_camera = report.T_world_camera = *corrected;
  report.registered = true;
}

inline void StaticMap::cloud_of_key_regions(const MapFrame& frame, std::vector<VoxelPoint>& cloud,
                                            MapReport& report) {
  key_regions_.mark(frame.detections, cut_.usable());
  cloud.clear();
  if (key_regions_.area().empty()) return;
  DepthSource inside = source(frame, key_regions_.inside());
  inside.labels = key_regions_.inside();
  inside.area = key_regions_.area();
  key_grid_.run(inside, cloud);
  report.outside += key_grid_.outside();
  report.key_points += cloud.size();
}

inline void StaticMap::append_in(Keyframe& keyframe, const Neighbour& neighbour) {
  const Pose T = inverse(keyframe.T_given) * neighbour.T_world_camera;
  for (VoxelPoint p : neighbour.cloud) {
    const Eigen::Vector3d q = T.R() * Eigen::Vector3d(p.x, p.y, p.z) + T.t();
    p.x = static_cast<float>(q.x()), p.y = static_cast<float>(q.y()), p.z = static_cast<float>(q.z());
    keyframe.key_cloud.push_back(p);
  }
}

inline void StaticMap::put_in(Keyframe& keyframe) {
  const std::size_t known = map_.size(), key_known = key_map_.size();
  outside_ = 0;
  fuse_points(map_, unit_m(), keyframe.cloud, 0, keyframe.T_world_camera, 1);
  fuse_points(key_map_, key_unit_m(), keyframe.key_cloud, 0, keyframe.T_world_camera, 1);
  if (!params_.carve.enabled) return;
  vote(keyframe, 0, 0, 1);
  for (const auto& other : keyframes_)
    if (other.get() != &keyframe) vote(*other, known, key_known, 1);
}

inline __attribute__((noinline)) std::size_t StaticMap::to_world(const std::vector<VoxelPoint>& cloud,
                                                                 std::size_t begin, const Pose& T,
                                                                 double unit_m,
                                                                 std::vector<WorldPoint>& world) {
  constexpr double kLimit = static_cast<double>(std::int64_t{VoxelKey::kOffset} << VoxelMap::kLeafBits);
  world.clear();
  double m[12];
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) m[4 * r + c] = T.rotation[3 * r + c] / unit_m;
    m[4 * r + 3] = T.translation_m[r] / unit_m;
  }
  std::size_t outside = 0;
  for (std::size_t i = begin; i < cloud.size(); ++i) {
    const VoxelPoint& p = cloud[i];
    WorldPoint w{{}, p.count, p.b, p.g, p.r, p.label};
    bool inside = true;
    for (std::size_t a = 0; a < 3; ++a) {
      const double q = m[4 * a] * static_cast<double>(p.x) + m[4 * a + 1] * static_cast<double>(p.y) +
                       m[4 * a + 2] * static_cast<double>(p.z) + m[4 * a + 3];
      inside = inside && q >= -kLimit && q < kLimit;
      const auto whole = static_cast<std::int32_t>(inside ? q : 0);
      w.units[a] = whole - (static_cast<double>(whole) > q ? 1 : 0);
    }
    if (inside)
      world.push_back(w);
    else
      ++outside;
  }
  return outside;
}

inline void StaticMap::make_room(MapReport& report) {
  while (map_.size() + key_map_.size() > static_cast<std::size_t>(params_.max_voxels) && map_.level() < 20) {
    double_leaf();
    report.leaf_doubled = true;
  }
  const double limit = params_.max_keyframe_mb * 1e6;
  while (!keyframes_.empty() &&
         (static_cast<double>(keyframe_bytes_) > limit || keyframes_.size() > kMaxKeyframes)) {
    const Keyframe& oldest = *keyframes_.front();
    if (params_.carve.enabled) {
      make_votes_permanent(map_, oldest.view, oldest.T_world_camera, leaf_m());
      make_votes_permanent(key_map_, oldest.view, oldest.T_world_camera, key_leaf_m());
    }
    report.made_permanent.push_back(oldest.id);
    keyframe_bytes_ -= bytes_of(oldest);
    keyframes_.pop_front();
    ++permanent_;
  }
}

}  // namespace dynfilter::mapping
