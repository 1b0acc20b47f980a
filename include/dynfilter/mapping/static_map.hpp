// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/depth_cut.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/depth_view.hpp>
#include <dynfilter/mapping/key_regions.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/registration.hpp>
#include <dynfilter/mapping/voxel_grid.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
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

/// The dense map of the static scene, built from keyframes (RTS-SLAM sec. 3.5).
/// Moving pixels are removed from each keyframe's depth image (DepthCut).
/// The rest becomes a cloud of voxel centroids in the camera frame.
/// The cloud is transformed by the pose and added to the world's voxels as integers.
/// A keyframe can therefore be removed or moved later.
/// The map is then bit for bit as if the keyframe had never been added, or had this pose.
///
/// Free space removes what a mask missed.
/// Each voxel counts how many keyframes see a surface there and how many see through it
/// (DepthView, Carving), regardless of their order.
/// A person who left is hidden once enough keyframes see the wall behind.
/// A new object in free space is added only after enough keyframes see it.
///
/// Memory is bounded. The map holds at most max_voxels; when it is full, leaves double.
/// Keyframe clouds and views take at most max_keyframe_mb.
/// Beyond that, the oldest keyframes become permanent.
/// They remain in the map, but can no longer be removed or moved.
/// Not thread-safe; see mapping_thread.hpp.
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

  /// Removes a keyframe. The map is then as if it had never been added.
  /// False if it is unknown or permanent.
  bool remove(std::int64_t id);

  /// Moves a keyframe to another pose, for example after loop closure, without alignment.
  /// False, without effect, if it is unknown or permanent or the pose is not rigid.
  bool move(std::int64_t id, const Pose& T_world_camera);

  bool can_move(std::int64_t id) const;

  /// The map as points, sorted by class and position. Equal maps give equal clouds.
  /// Excludes voxels that were seen through and isolated voxels.
  /// Excludes coarse voxels where fine voxels of key objects exist.
  MapCloud cloud() const;

  /// The keyframes that contribute to each point of cloud().
  /// A neighbour's points count as those of its keyframe.
  /// Recomputed from the keyframes' clouds, in about the time of their fusion.
  MapSources sources() const;

  MapState state() const;
  const MappingParams& params() const { return params_; }
  const VoxelMap& voxels() const { return map_; }
  const VoxelMap& key_voxels() const { return key_map_; }
  double leaf_m() const { return params_.leaf_m * std::ldexp(1.0, map_.level()); }
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
  Keyframe* find(std::int64_t id);

  static std::string why_not(const MapFrame& frame);

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
  void take_out(Keyframe& keyframe);

  /// Sign 1 adds, -1 removes.
  void fuse_points(VoxelMap& map, double unit_m, const std::vector<VoxelPoint>& cloud, std::size_t begin,
                   const Pose& T, int sign);
  /// Converts points to quanta of the map. Returns how many are out of range.
  /// noinline: all callers must compute identical results.
  static std::size_t to_world(const std::vector<VoxelPoint>& cloud, std::size_t begin, const Pose& T,
                              double unit_m, std::vector<WorldPoint>& world);

  /// Adds a keyframe's votes on the voxels from these indices.
  void vote(const Keyframe& keyframe, std::size_t begin, std::size_t key_begin, int sign);
  void vote_on_new(VoxelMap& map, std::size_t begin, double leaf_m);

  void make_room(MapReport& report);

  static constexpr float kFarthestM = 65;              ///< range of DepthView
  static constexpr std::size_t kMaxKeyframes = 60000;  ///< votes count up to 65535

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

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/static_map-inl.hpp>
#endif
