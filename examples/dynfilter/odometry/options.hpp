// SPDX-License-Identifier: MIT
#pragma once

#include "sensor.hpp"

namespace dynfilter::odometry {

/// Feature extraction.
struct ExtractorOptions {
  int features = 1000;
  int levels = 8;
  double scale_factor = 1.2;
  int fast_threshold = 20;
  int fast_threshold_weak = 7;  ///< for cells where fast_threshold finds nothing
  int cell_px = 32;
};

/// Acceptance of measured depth, and its weight relative to pixels.
struct DepthOptions {
  double max_m = 10.0;
  int edge_radius_px = 2;          ///< a depth jump within this radius is a silhouette: no depth
  double edge_ratio = 0.03;        ///< a jump: max - min > edge_ratio z + edge_noise_per_m z^2
  double edge_noise_per_m = 0.01;  ///< quantisation and noise of disparity
  double baseline_fx_px_m = 40.0;  ///< of the structured-light camera, converts depth to disparity
  /// Noise of that disparity, with errors of registration: residuals on four recordings are 0.1 to 0.3 px.
  double disparity_sigma_px = 0.25;
};

/// Matches of features in a rectified right image.
struct StereoOptions {
  double row_tolerance_px = 2.0;    ///< at octave 0; grows with the octave
  double nearest_baselines = 3.0;   ///< nearest depth that is searched, in baselines
  double tolerance_px = 1.0;        ///< disparities may be negative by this, as noise
  double least_disparity_px = 2.0;  ///< smaller: a match, but no depth
  int max_distance = 75;            ///< Hamming, of 256
  double max_patch_ratio = 2.1;     ///< of a patch's difference to the median one
  double disparity_sigma_px = 0.5;  ///< at octave 0; grows with the octave
};

/// The first map of a mono camera.
struct StartOptions {
  int min_matches = 100;         ///< fewer: this frame is the new reference
  double radius_px = 100.0;      ///< of the search around the last match
  int max_distance = 50;         ///< Hamming, of 256
  double max_ratio = 0.9;        ///< best / second-best distance
  double ransac_px = 1.5;        ///< of inliers of both models
  double plane_share = 0.45;     ///< of both scores; above it the homography is used
  int min_points = 50;           ///< in front of both cameras
  double max_rival_share = 0.7;  ///< points of the second-best motion
  double min_parallax_deg = 1.0;
  int young_keyframes = 5;    ///< a map with at most these is started again when it is lost
  double median_depth = 3.0;  ///< of the first points: the unit of a mono map
  double scale_factor = 1.2;  ///< of the image pyramid
};

/// Points from two keyframes, for features without depth.
struct NewPointOptions {
  int neighbours = 6;                  ///< keyframes that share most points
  double least_baseline_share = 0.01;  ///< of the median depth
  int max_distance = 50;               ///< Hamming, of 256
  double line_reach_px = 2.0;          ///< from the epipolar line, at octave 0
  double max_cosine = 0.9998;          ///< of the parallax: 1.1 degrees
};

struct MatchOptions {
  /// Around the position that the motion model predicts, at octave 0.
  double motion_radius_px = 15.0;
  /// Around the position that a first pose predicts, at octave 0. In a blurred turn that is some pixels off.
  double map_radius_px = 6.0;
  int max_distance = 80;   ///< Hamming, of 256
  double max_ratio = 0.9;  ///< best / second-best distance
};

struct KeyframeOptions {
  int max_gap_frames = 3;           ///< with 5, a keyframe in the blur of a turn tilts all that follow
  double min_tracked_share = 0.75;  ///< share of the map points that the last keyframe observes
  double max_rotation_deg = 10.0;
  double max_translation_ratio = 0.08;  ///< share of the median depth
};

struct BundleOptions {
  int window = 7;  ///< keyframes with free poses
  /// Maximum number of further keyframes that observe the same points, with fixed poses.
  int fixed_keyframes = 6;
  int max_points = 1200;  ///< those with most observations
  int max_iterations = 5;
};

struct OdometryOptions {
  Sensor sensor = Sensor::Rgbd;
  bool poses = true;    ///< false: features and the judge's verdicts only, for a camera that is not known
  bool weights = true;  ///< features that slide along an edge count across it only
  ExtractorOptions extractor;
  DepthOptions depth;
  StereoOptions stereo;
  StartOptions start;
  NewPointOptions new_points;
  MatchOptions match;
  KeyframeOptions keyframe;
  BundleOptions bundle;
  int min_initial_points = 60;       ///< features with depth needed to start a map
  int min_inliers = 20;              ///< fewer: lost
  int min_relocalised_inliers = 30;  ///< fewer: still lost
  int max_keyframes = 500;           ///< the oldest beyond it are removed, with points only they observe
  int local_keyframes = 10;          ///< keyframes that provide the points to search in a frame
  double max_time_gap_s = 1.0;       ///< a longer gap is a time jump
};

}  // namespace dynfilter::odometry
