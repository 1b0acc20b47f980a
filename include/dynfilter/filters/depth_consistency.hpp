// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/camera_motion.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/seen_depth.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// The earlier view that predicts the depth.
enum class DepthReference {
  Frame,     ///< the frame gap_frames back
  Keyframe,  ///< the last keyframe
  Covisible  ///< FrameView::covisible_keyframes
};
/// How the earlier view predicts the depth.
enum class DepthPrediction {
  Match,  ///< depth of the feature's point in the reference, moved to the current frame
  View,   ///< depth that the reference view has at the feature's position
  Both
};
/// Form of the depth deviation.
enum class DepthForm {
  Relative,  ///< share of the depth (DeS-SLAM)
  Metric     ///< metres (DynaSLAM)
};

struct DepthConsistencyParams {
  DepthReference against = DepthReference::Frame;
  int gap_frames = 1;
  DepthPrediction prediction = DepthPrediction::Both;
  DepthForm form = DepthForm::Relative;
  double max_deviation = 0.12;
  double max_difference_m = 0.4;
  /// Largest angle between the rays of two views to the point; other views abstain (DynaSLAM: 30).
  static constexpr double kMaxParallax_deg = 30;
  /// Radius of the patch whose depths separate edges from motion; 0: one pixel.
  static constexpr int kPatch_px = 3;
  static constexpr double kMaxDepth_m = 6.0;  ///< Largest depth of a feature that is judged.
  MotionSource motion = MotionSource::Seeds;

  static const FieldTable<DepthConsistencyParams>& fields();
};

/// Rejects features whose depth differs from the prediction of an earlier view of a static scene (DeS-SLAM
/// sec. 3.2, eq. 1-6; DynaSLAM sec. III-C).
///
/// Formula:  Form relative: |1 - d_proj / z| > max_deviation, at keyframes |z_r - d_r| / z_r. Form metric:
///           d_proj - z > max_difference_m. Prediction match: d_proj is the depth of the feature's point in
///           the reference, moved by the camera's motion. Prediction view: the feature is projected into the
///           reference, and d_proj is the depth of the reference there. Only a larger depth is evidence of
///           motion; a smaller one occludes the place.
/// Needs:    depth, camera, and one of:
///           correspondences (for match, and to fit the motion); covisible keyframes with poses.
/// Abstains: without depth, beyond 6 m, on silhouettes,
///           where the place was occluded or out of view, and without a motion.
/// Blind to: motion across the line of sight (match), inside the outline of a large mover (view), and below
///           the threshold, which is 0.36 m at 3 m for 12 %.
/// State:    none; the pipeline keeps gap_frames frames.
/// Cost:     about 0.1 ms for 1000 features, with motion, without flow.
class DepthConsistencyFilter final : public ParametricFilter<DepthConsistencyFilter, DepthConsistencyParams> {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "depth_consistency";
  static constexpr const char* kSummary =
      "features whose depth differs from the prediction of an earlier view";
  Needs needs() const override;
  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  /// Result of one view for one feature.
  struct Opinion {
    bool dynamic = false, fixed = false;
    float suspicion = 0;

    void add(Vote vote, double deviation, double limit);
    Vote vote() const { return dynamic ? Vote::Dynamic : fixed ? Vote::Static : Vote::Unknown; }
  };
  /// Votes of several views.
  struct Tally {
    int dynamic = 0, fixed = 0;
    float suspicion = 0;
  };

  bool by_match() const { return params_.prediction != DepthPrediction::View; }
  bool by_view() const { return params_.prediction != DepthPrediction::Match; }
  double limit() const {
    return params_.form == DepthForm::Relative ? params_.max_deviation : params_.max_difference_m;
  }
  /// Predicted minus measured depth, in metres or as a share of `of_m`.
  double deviation(double predicted_m, double measured_m, double of_m) const;
  bool judgeable(const Evidence& evidence, std::size_t i) const;

  // ---- against one earlier frame
  void judge_by_frame(const Evidence& evidence, const Match& match, const Pose& T_current_reference,
                      Votes& votes);

  /// A depth other than predicted is motion, except at a depth edge, where the match has slid across.
  void add_match(const cv::Point3f& now, double predicted_m, Opinion& opinion) const;
  bool beside_edge(const cv::Point3f& now, double predicted_m) const;
  void add_view(const Eigen::Vector3d& point_m, Opinion& opinion) const;

  /// True if the rays to a point from the origin and from `centre_m` enclose a small enough angle.
  bool parallax_fits(const Eigen::Vector3d& point_m, const Eigen::Vector3d& centre_m) const;

  // ---- against the covisible keyframes
  void judge_by_keyframes(const Evidence& evidence, Votes& votes);

  void judge_by_keyframe(const Evidence& evidence, const KeyframeView& keyframe);

  /// Equation 5: z_r is the map point's depth in the keyframe, d_r that of the feature's reprojected point.
  void add_map_point(const Pose& T_keyframe_world, const cv::Point3f& world_m, double reprojected_m,
                     Opinion& opinion) const;

  bool learn_points(const Evidence& evidence, const KeyframeView& keyframe);
  bool seen_by_keyframe(std::int64_t map_point_id) const {
    return map_point_id >= 0 &&
           std::binary_search(keyframe_points_.begin(), keyframe_points_.end(), map_point_id);
  }

  std::vector<int> seeds_;
  SeenDepth view_, here_;
  std::vector<Tally> tallies_;
  std::vector<std::int64_t> keyframe_points_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/depth_consistency-inl.hpp>
#endif
