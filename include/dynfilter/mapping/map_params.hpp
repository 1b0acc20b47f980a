// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/parameters.hpp>
#include <string>
#include <vector>

namespace dynfilter::mapping {

/// What is done with the boxes of things that may move, where they come without a mask.
enum class BoxCut {
  Ignore,      ///< nothing: masks and dynamic features only
  Foreground,  ///< the body in the box (box_body.hpp), and what it goes on to without a depth jump
  All,         ///< the entire box
};

/// How moving things and doubtful depths are cut out of a depth image (depth_cut.hpp).
struct CutParams {
  BoxCut boxes = BoxCut::Foreground;
  std::vector<std::string> moving_classes = dynfilter::moving_classes();
  double cluster_eps_m = 0.3;
  int cluster_min_points = 4;
  double grow_reach_m = 0.6;
  int band_px = 6;
  double max_step_share = 0.02;
  int edge_px = 1;

  static const FieldTable<CutParams>& fields() {
    using P = CutParams;
    static const FieldTable<P> table{
        choice("moving_boxes", &P::boxes,
               {{"ignore", BoxCut::Ignore}, {"foreground", BoxCut::Foreground}, {"all", BoxCut::All}},
               "what is cut out of boxes of moving classes that come without a mask"),
        words("moving_classes", &P::moving_classes, "names of detections that may move"),
        real("cluster_eps_m", &P::cluster_eps_m, "m", {0.001, 100},
             "radius in which dynamic features are one cluster"),
        integer("cluster_min_points", &P::cluster_min_points, "", {1, 1000},
                "dynamic features that make a moving object; fewer are left alone"),
        real("grow_reach_m", &P::grow_reach_m, "m", {0, 100},
             "how far an object reaches from its features; 0: any"),
        integer("band_px", &P::band_px, "px", {0, 100}, "rim around what moves that is cut out, too"),
        real("max_step_share", &P::max_step_share, "of the depth", {0, 10},
             "a larger step to the next pixel, beyond the noise, is a depth jump; 0: none is looked for"),
        integer("edge_px", &P::edge_px, "px", {0, 20}, "rim left out on both sides of a depth jump"),
    };
    return table;
  }
};

/// When measured free space removes points (depth_view.hpp).
struct CarveParams {
  bool enabled = true;
  double margin_m = 0.05;
  double noise_sigmas = 3;
  int min_views = 1;
  double seen_per_through = 3;
  int spread_max_seen = 2;
  double spread_share = 0.2;

  static const FieldTable<CarveParams>& fields() {
    using P = CarveParams;
    static const FieldTable<P> table{
        flag("carve", &P::enabled, "remove what other keyframes see through"),
        real("carve_margin_m", &P::margin_m, "m", {0, 100},
             "how far behind a point a depth must lie at least"),
        real("carve_noise_sigmas", &P::noise_sigmas, "", {0, 100},
             "and beyond the depth's noise, in standard deviations"),
        integer("carve_min_views", &P::min_views, "", {1, 1000}, "keyframes that must see through a point"),
        real("seen_per_through", &P::seen_per_through, "", {0, 1e6},
             "keyframes that saw a surface there outvote this share of them: hidden when seen < this x "
             "through"),
        integer("spread_max_seen", &P::spread_max_seen, "", {0, 65535},
                "what so few keyframes saw goes with its neighbours; 0: stays"),
        real("spread_share", &P::spread_share, "", {0, 1},
             "when this share of its neighbours within two voxels is gone"),
    };
    return table;
  }
};

/// Statistical outlier removal (outliers.hpp).
struct OutlierParams {
  bool enabled = true;
  int neighbours = 8;
  double sigmas = 3;

  static const FieldTable<OutlierParams>& fields() {
    using P = OutlierParams;
    static const FieldTable<P> table{
        flag("outliers", &P::enabled, "remove lonely voxels"),
        integer("outlier_neighbours", &P::neighbours, "", {1, 64},
                "so many nearest neighbours are looked at"),
        real("outlier_sigmas", &P::sigmas, "", {0, 1000},
             "lonely: their mean distance is so many standard deviations above that of all voxels"),
    };
    return table;
  }
};

/// Alignment of a keyframe with the map before it is fused (registration.hpp).
struct RegistrationParams {
  bool enabled = false;
  double max_correction_m = 0.05;
  double max_correction_deg = 3;
  int min_points = 300;

  static const FieldTable<RegistrationParams>& fields() {
    using P = RegistrationParams;
    static const FieldTable<P> table{
        flag("register_keyframes", &P::enabled, "align each keyframe with the map before it is fused"),
        real("max_correction_m", &P::max_correction_m, "m", {0, 10}, "a larger correction is not believed"),
        real("max_correction_deg", &P::max_correction_deg, "deg", {0, 90}, "nor a larger turn"),
        integer("registration_min_points", &P::min_points, "", {20, 2000}, "with fewer pairs it abstains"),
    };
    return table;
  }
};

/// The map. Leaf: voxel edge r_v outside of the key regions.
struct MappingParams {
  double leaf_m = 0.02;
  int max_voxels = 2000000;
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
                  "when the map holds more, its leaf doubles"),
          real("max_keyframe_mb", &P::max_keyframe_mb, "MB", {0, 1e6},
               "for keyframes that can still be removed or moved; the oldest become permanent"),
          real("min_depth_m", &P::min_depth_m, "m", {0, 1000}, "nearer depths are not used"),
          real("max_depth_m", &P::max_depth_m, "m", {0.01, 1000}, "farther depths are not used"),
          words("key_classes", &P::key_classes, "detections of static objects that are kept at full density"),
          integer("key_divisor", &P::key_divisor, "", {1, 64},
                  "leaf in key regions: leaf_m divided by this power of two"),
          integer("key_window", &P::key_window, "frames", {0, 1000},
                  "frames before and after a keyframe that refine its key regions (N_w)"),
      };
      include_fields(t, &P::cut);
      include_fields(t, &P::carve);
      include_fields(t, &P::outliers);
      include_fields(t, &P::registration);
      return t;
    }();
    return table;
  }
};

/// Throws ConfigError, naming the parameter, also for what a single range cannot say.
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
