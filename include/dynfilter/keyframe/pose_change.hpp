// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <dynfilter/keyframe/selector.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

struct PoseChangeParams {
  double min_translation_m = 0.10;
  double min_rotation_deg = 10;
  bool require_motion = false;
  int min_gap_frames = 1;
  int max_gap_frames = 20;
  double min_shared_share = 0.75;
  int max_dynamic_features = 300;

  static const FieldTable<PoseChangeParams>& fields();
};

/// Keyframe selection of DeS-SLAM: relative pose to the last keyframe, and ORB-SLAM2's criteria.
/// The latter are frames since the last keyframe and the share of its points still visible.
/// The paper gives no thresholds and no rule to combine them.
/// By default each criterion alone is sufficient.
/// With `require_motion` the other criteria count only after camera motion, which saves keyframes.
/// Decides immediately.
class PoseChangeSelector final : public KeyframeSelector {
 public:
  static constexpr const char* kName = "pose_change";

  /// Throws ConfigError if a parameter is out of range.
  explicit PoseChangeSelector(const PoseChangeParams& params = PoseChangeParams());

  std::string name() const override { return kName; }

 protected:
  std::vector<SelectedFrame> choose(const FrameSummary& frame) override;

  void forget() override { last_.reset(); }

 private:
  struct Last {
    std::int64_t id;
    Pose T_world_camera;
    std::vector<std::int64_t> points;
  };

  bool is_due(const FrameSummary& frame, const std::vector<std::int64_t>& points,
              KeyframeReason& reason) const;

  PoseChangeParams params_;
  std::optional<Last> last_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/pose_change-inl.hpp>
#endif
