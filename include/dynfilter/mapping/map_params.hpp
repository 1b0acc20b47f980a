// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <string>
#include <vector>

namespace dynfilter::mapping {

/// What is removed for boxes of moving classes without a mask.
enum class BoxCut {
  Ignore,      ///< nothing; only masks and dynamic features are removed
  Foreground,  ///< the body in the box (box_body.hpp), and what it reaches without a depth jump
  All,         ///< the entire box
};

/// How moving objects and unreliable depths are removed from a depth image (depth_cut.hpp).
struct CutParams {
  /// What is removed for boxes of moving classes without a mask. Not a key: code sets it.
  BoxCut boxes = BoxCut::Foreground;
  std::vector<std::string> moving_classes = dynfilter::moving_classes();
  /// Radius of the neighbourhood in which dynamic features form a cluster.
  static constexpr double kClusterEps_m = 0.3;
  /// Smallest number of dynamic features that makes a moving object.
  static constexpr int kClusterMinPoints = 4;
  /// Largest distance of an object's pixels from its features; 0: no limit.
  static constexpr double kGrowReach_m = 0.6;
  /// Width of the rim around moving objects that is also removed. Not a key: code sets it.
  int band_px = 6;
  /// Depth step to the next pixel, beyond the noise, that counts as a depth jump; 0: no detection.
  static constexpr double kMaxStepShare = 0.02;
  /// Width of the rim that is removed on both sides of a depth jump. Not a key: code sets it.
  int edge_px = 1;

  static const FieldTable<CutParams>& fields() {
    using P = CutParams;
    static const FieldTable<P> table{
        words("moving_classes", &P::moving_classes, "names of the detection classes that may move"),
    };
    return table;
  }
};

/// When measured free space removes points (depth_view.hpp).
struct CarveParams {
  bool enabled = true;
  /// Smallest distance between a point and the surface behind it that is seen through it.
  static constexpr double kMargin_m = 0.05;
  /// Standard deviations of the depth noise that are added to the margin.
  static constexpr double kNoiseSigmas = 3;
  /// Smallest number of keyframes that must see through a point.
  int min_views = 1;
  /// A point is hidden if fewer keyframes see its surface than this times those that see through it.
  static constexpr double kSeenPerThrough = 3;
  /// Largest number of observations of a point that is removed with its neighbours; 0: no such removal.
  static constexpr int kSpreadMaxSeen = 2;
  /// Smallest share of removed neighbours within two voxels that removes such a point.
  static constexpr double kSpreadShare = 0.2;

  static const FieldTable<CarveParams>& fields() {
    using P = CarveParams;
    static const FieldTable<P> table{
        flag("carve", &P::enabled, "remove points that other keyframes see through"),
        integer("carve_min_views", &P::min_views, "", {1, 1000},
                "smallest number of keyframes that must see through a point"),
    };
    return table;
  }
};

/// Statistical outlier removal (outliers.hpp).
struct OutlierParams {
  bool enabled = true;  ///< Remove isolated voxels. Not a key: code sets it.
  /// Number of nearest neighbours whose distance is averaged. Not a key: code sets it.
  int neighbours = 8;
  /// A voxel is isolated if its mean distance exceeds the mean of all voxels by this many standard
  /// deviations. Not a key: code sets it.
  double sigmas = 3;
};

/// Alignment of a keyframe with the map before fusion (registration.hpp).
struct RegistrationParams {
  bool enabled = false;
  /// Largest correction of the position that is accepted. Not a key: code sets it.
  double max_correction_m = 0.05;
  /// Largest correction of the rotation that is accepted.
  static constexpr double kMaxCorrection_deg = 3;
  /// Smallest number of point pairs; with fewer, the keyframe is not aligned.
  static constexpr int kMinPoints = 300;

  static const FieldTable<RegistrationParams>& fields() {
    using P = RegistrationParams;
    static const FieldTable<P> table{
        flag("register_keyframes", &P::enabled, "align each keyframe with the map before fusion"),
    };
    return table;
  }
};

/// Parameters of the map. leaf_m is the voxel edge r_v outside the key regions.
struct MappingParams {
  double leaf_m = 0.02;
  int max_voxels = 2000000;
  /// Memory for keyframes that can be removed or moved; beyond it, the oldest become permanent. Not a key:
  /// code sets it.
  double max_keyframe_mb = 512;
  double min_depth_m = 0.3;
  double max_depth_m = 5;
  CutParams cut;
  CarveParams carve;
  OutlierParams outliers;
  RegistrationParams registration;
  std::vector<std::string> key_classes{"book", "keyboard", "tv", "tvmonitor", "monitor", "laptop", "mouse"};
  int key_divisor = 4;
  int key_window = 5;

  static const FieldTable<MappingParams>& fields() {
    using P = MappingParams;
    static const FieldTable<P> table = [] {
      FieldTable<P> t{
          real("leaf_m", &P::leaf_m, "m", {0.001, 10}, "edge of a voxel"),
          integer("max_voxels", &P::max_voxels, "", {1000, 100000000},
                  "largest number of voxels; beyond it, the leaf doubles"),
          real("min_depth_m", &P::min_depth_m, "m", {0, 1000}, "smallest depth that is used"),
          real("max_depth_m", &P::max_depth_m, "m", {0.01, 1000}, "largest depth that is used"),
          words("key_classes", &P::key_classes, "classes of static objects that are kept at full density"),
          integer("key_divisor", &P::key_divisor, "", {1, 64},
                  "power of two that divides leaf_m in key regions"),
          integer("key_window", &P::key_window, "frames", {0, 1000},
                  "frames before and after a keyframe that refine its key regions (N_w)"),
      };
      include_fields(t, &P::cut);
      include_fields(t, &P::carve);
      include_fields(t, &P::registration);
      return t;
    }();
    return table;
  }
};

/// Throws ConfigError with the parameter, also for combinations that are invalid.
inline void check_mapping(const MappingParams& p, const std::string& path = "mapping") {
  check_parameters(p, path);
  if (p.min_depth_m >= p.max_depth_m)
    throw ConfigError(path + ".max_depth_m", "expected more than min_depth_m");
  if (p.leaf_m > p.max_depth_m)
    throw ConfigError(path + ".leaf_m", "expected at most max_depth_m: the scene would be one voxel");
  if ((p.key_divisor & (p.key_divisor - 1)) != 0)
    throw ConfigError(path + ".key_divisor", "expected a power of two: 1, 2, 4, ... 64");
}

}  // namespace dynfilter::mapping
