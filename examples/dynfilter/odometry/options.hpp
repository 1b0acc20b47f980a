// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter::odometry {

/// How features are found.
struct ExtractorOptions {
  int features = 1000;
  int levels = 8;
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int fast_threshold_weak = 7;  ///< in cells where the first one finds nothing
  int cell_px = 32;
};

/// When measured depth is believed, and how much it weighs against pixels.
struct DepthOptions {
  double max_m = 10.0;
  int edge_radius_px = 2;           ///< depth that jumps within this radius is a silhouette's: none
  double edge_ratio = 0.03;         ///< a jump: max - min > edge_ratio z + edge_noise_per_m z^2
  double edge_noise_per_m = 0.01;   ///< quantisation and noise of disparity
  double baseline_fx_px_m = 40.0;   ///< of the structured-light camera: turns depth into disparity
  double disparity_sigma_px = 0.5;  ///< noise of that disparity, registration errors included
};

struct MatchOptions {
  double motion_radius_px = 15.0;  ///< around the place that the motion model predicts, at octave 0
  double map_radius_px = 4.0;      ///< around the place that a first pose predicts, at octave 0
  int max_distance = 80;           ///< Hamming, of 256
  double max_ratio = 0.9;          ///< best / second best
};

struct KeyframeOptions {
  int max_gap_frames = 5;
  double min_tracked_share = 0.75;  ///< of the map points that the last keyframe saw
  double max_rotation_deg = 10.0;
  double max_translation_ratio = 0.08;  ///< of the median depth
};

struct BundleOptions {
  int window = 7;           ///< keyframes whose poses move
  int fixed_keyframes = 6;  ///< at most this many more see the same points and stay
  int max_points = 1200;    ///< those seen most often
  int max_iterations = 5;
};

struct OdometryOptions {
  ExtractorOptions extractor;
  DepthOptions depth;
  MatchOptions match;
  KeyframeOptions keyframe;
  BundleOptions bundle;
  int min_initial_points = 60;       ///< features with depth that start a map
  int min_inliers = 20;              ///< fewer: lost
  int min_relocalised_inliers = 30;  ///< fewer: still lost
  int local_keyframes = 10;          ///< whose points are looked for in a frame
  double max_time_gap_s = 1.0;       ///< a longer gap is a time jump
};

}  // namespace dynfilter::odometry
