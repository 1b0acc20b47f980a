// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/matched_features.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

struct TwoViewModel;
struct RigidMotion;

/// What a filter may know of the current frame: the frame itself, what is measured in it, and what earlier
/// stages said. Read-only. Measurements are computed when a filter first uses them, once per frame, and all
/// filters share them. References are valid until the end of the frame.
/// An interface without storage: a plugin works with any implementation of it.
class Evidence {
 public:
  virtual ~Evidence() = default;

  // ---- the frame
  /// Checked and cleaned (evidence/clean_frame.hpp).
  virtual const FrameView& frame() const = 0;
  virtual CallPoint call_point() const = 0;  ///< where in the host's tracking the frame is judged
  /// The inputs that this frame has.
  virtual Input inputs() const = 0;
  /// Number of features.
  virtual std::size_t size() const = 0;
  /// Distorted pixels, one per feature. NaN: the keypoint is in no image.
  virtual const std::vector<cv::Point2f>& pixels() const = 0;
  /// Undistorted pixels: the host's, else computed with the camera, else the distorted ones.
  virtual const std::vector<cv::Point2f>& undistorted_pixels() const = 0;
  /// Depth along the optical axis [m].
  /// NaN: no depth, beyond `max_depth_m`, or on a silhouette of the depth image.
  virtual const std::vector<float>& depths_m() const = 0;
  /// Points in the frame of the current camera [m]. NaN without depth.
  virtual const std::vector<cv::Point3f>& points_m() const = 0;

  // ---- what earlier stages said, per feature: 1 or 0
  /// This stage judges the feature. A sequence passes on the survivors, a gate one side.
  virtual Span<const std::uint8_t> judged() const = 0;
  /// A semantic stage marked the feature as a suspect.
  virtual Span<const std::uint8_t> prior() const = 0;
  /// Models may be fitted on the feature, because no earlier stage suspects it.
  virtual Span<const std::uint8_t> seed() const = 0;
  /// An earlier stage of a sequence voted the feature dynamic. It is not judged again.
  virtual Span<const std::uint8_t> called_dynamic() const = 0;
  bool judged(std::size_t i) const { return judged()[i] != 0; }                  ///< the same for feature i
  bool prior(std::size_t i) const { return prior()[i] != 0; }                    ///< the same for feature i
  bool seed(std::size_t i) const { return seed()[i] != 0; }                      ///< the same for feature i
  bool called_dynamic(std::size_t i) const { return called_dynamic()[i] != 0; }  ///< the same for feature i
  /// Number of features that this stage judges.
  std::size_t count_judged() const {
    std::size_t n = 0;
    for (const std::uint8_t j : judged()) n += j;
    return n;
  }
  /// Whether any feature is a prior suspect.
  bool any_prior() const {
    for (const std::uint8_t p : prior())
      if (p != 0) return true;
    return false;
  }

  // ---- earlier frames
  /// Positions of the features in an earlier frame.
  /// Without that frame, no entry is found and `reference` is null.
  virtual const Match& match(const Reference& reference) const = 0;
  /// The same for the frame with this id, for results that arrive late.
  virtual const Match& match_with(std::int64_t frame_id) const = 0;
  /// The same, after features in `doubted` (1 or 0, each) that have a depth were tracked from where they were
  /// if at rest. What is found within 2 px of there, and is no less alike, replaces the match. `match` itself
  /// without a reference or images.
  virtual const Match& second_look(const Match& match, const Pose& T_current_reference,
                                   Span<const std::uint8_t> doubted) const = 0;
  /// The reference frame's feature of each match, and the distance of their descriptors. `max_offset_px`: how
  /// far from the end of optical flow that feature may be.
  virtual const MatchedFeatures& matched_features(
      const Match& match, double max_offset_px = MatchedFeatures::kMaxOffsetPx) const = 0;
  /// Each feature's way through earlier frames. Ask in every frame: one left out starts all tracks anew.
  virtual const FeatureTracks& tracks(const TrackOptions& options) const = 0;
  /// A frame that is still kept, this one included. Null: no longer, or never.
  virtual const PastFrame* kept_frame(std::int64_t frame_id) const = 0;

  // ---- models
  /// Features with a correspondence that may support a model.
  /// With `all`, the result of earlier stages is ignored.
  virtual void collect_seeds(const Match& match, bool all, std::vector<int>& seeds) const = 0;
  /// The two-view model fitted on the seeds of a match (geometry/two_view.hpp).
  virtual const TwoViewModel& two_view(const Match& match, const std::vector<int>& seeds) const = 0;
  /// Camera motion since the match's reference, fitted on 3-D seeds (geometry/rigid_motion.hpp). A motion
  /// that the host predicts competes as a hypothesis. Otherwise a mover with most of the features would win.
  virtual const RigidMotion& rigid_motion(const Match& match, const std::vector<int>& seeds) const = 0;
  /// T_current_reference from the host's poses, if both frames have one.
  virtual std::optional<Pose> host_motion(const Match& match) const = 0;
  /// FrameView::motion_prior, if it begins at the match's reference.
  virtual std::optional<MotionPrior> motion_prior(const Match& match) const = 0;

  // ---- late results
  /// The boxes of an older frame, carried to this one, with track ids (late/late_semantics.hpp). They were
  /// found on that frame, or at most `max_age_frames` before and missed since. Null when nothing leads here.
  virtual const std::vector<Detection>* carried_boxes(int max_age_frames) const = 0;
  /// A mask of an older frame, carried to this one, at a quarter of the image's width and height.
  /// Null when nothing leads here.
  virtual const cv::Mat* carried_labels() const = 0;
};

}  // namespace dynfilter
