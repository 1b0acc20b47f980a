// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/config/field_table.hpp>
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
  BoxCut boxes = BoxCut::Foreground;
  std::vector<std::string> moving_classes = dynfilter::moving_classes();
  double cluster_eps_m = 0.3;
  int cluster_min_points = 4;
  double grow_reach_m = 0.6;
  int band_px = 6;
  double max_step_share = 0.02;
  int edge_px = 1;

  static const FieldTable<CutParams>& fields();
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

  static const FieldTable<CarveParams>& fields();
};

/// Statistical outlier removal (outliers.hpp).
struct OutlierParams {
  bool enabled = true;
  int neighbours = 8;
  double sigmas = 3;

  static const FieldTable<OutlierParams>& fields();
};

/// Alignment of a keyframe with the map before fusion (registration.hpp).
struct RegistrationParams {
  bool enabled = false;
  double max_correction_m = 0.05;
  double max_correction_deg = 3;
  int min_points = 300;

  static const FieldTable<RegistrationParams>& fields();
};

/// Parameters of the map. leaf_m is the voxel edge r_v outside the key regions.
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

  static const FieldTable<MappingParams>& fields();
};

/// Throws ConfigError with the parameter, also for combinations that are invalid.
void check_mapping(const MappingParams& p, const std::string& path = "mapping");

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/map_params-inl.hpp>
#endif
