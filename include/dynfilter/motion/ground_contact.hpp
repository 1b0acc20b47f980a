// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/motion/expiring.hpp>
#include <dynfilter/motion/flow_groups.hpp>
#include <dynfilter/motion/ground_plane.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// A point that is compared with the ground.
struct GroundedPoint {
  GroundPoint at;
  double x_px = 0, y_px = 0;  ///< from the principal point
  double line_px = 1;  ///< flow per inverse depth: the noise of the inverse depth is noise_px / line_px
  bool shows_ground = false;  ///< follows the static scene otherwise
};

/// The frame in which points are compared with the ground.
struct GroundView {
  double gap_s = 0;       ///< over which the points moved
  double height_px = 0;   ///< of the image
  double focus_y_px = 0;  ///< of the focus of expansion, from the principal point: on the horizon
  double noise_px = 0;    ///< of the flow
  double limit = 2;       ///< [sigma] from which evidence counts
  double most = 6;        ///< [sigma] of one frame
};

/// Finds movers that a forward moving camera sees move along their epipolar lines. Over a flat ground of
/// which the camera is one height above, a point `below` the horizon has at least the inverse depth scale *
/// below.
///
/// Farther: a car that drives ahead hardly flows, so it seems to be beneath the ground:
///   sigmas = (1 - inverse_depth / (scale * below)) / hypot(0.15, noise / (line * scale * below)).
///   Each point is compared together with neighbours of similar flow; a group has the evidence of its lower
///   part, up to the height of a van. The ground must be seen at this distance: a road may bend downwards.
/// Nearer: an oncoming car flows too fast, so its lower end seems to hover:
///   sigmas = limit + log(ratio of the group's lowest tenth / 1.2 / (1 + 1 / n)) / 0.15.
///   Only for upright groups whose lower end is in the image. If the group was static and hovered by
///   occlusion, the ground between its lower end and the place where it would stand is hidden. So ground must
///   be
///   seen there, or the group be large with nothing nearer in front of it.
/// Blind to: slopes whose ground is seen (a hill's near side); movers above the horizon.
/// Cost: 0.1 ms for 1000 points, without finding the ground (0.2 ms).
class GroundContact {
 public:
  void reset() { ground_.reset(); }
  /// A frame begins, `passed_s` after the last one: ground that no frame shows is forgotten.
  void pass(double passed_s) { ground_.pass(passed_s); }
  /// The plane that was seen last; nullopt: none.
  const std::optional<GroundPlane>& ground() const { return ground_.value(); }

  /// Standard deviations by which each point is off the ground; nullopt: it cannot be compared.
  /// Empty if no ground is found.
  const std::vector<std::optional<double>>& compare(const std::vector<GroundedPoint>& points,
                                                    const FlowGroups& groups, const GroundView& view);

 private:
  static constexpr double kGroundSmoothing = 0.5;  ///< weight of a new frame's ground
  /// [heights] smallest distance below the horizon of points that show the ground.
  static constexpr double kGroundBelow = 0.08;
  /// [heights] smallest distance below the horizon of points compared with the ground.
  static constexpr double kLeastBelow = 0.04;
  static constexpr std::size_t kGroup = 4;  ///< smallest number of points
  static constexpr std::size_t kFew = 3;    ///< values of which a median is taken, at least
  /// Ratios to the ground's inverse depth. The ground's own spread on real streets is 0.9 to 1.15.
  static constexpr double kLeastGround = 0.8, kMostGround = 1.2;
  static constexpr double kRatioSigma = 0.15;  ///< of the logarithm of the ratio
  static constexpr double kOnGround = 1;       ///< [sigma] nearer to the ground than that: on it
  static constexpr double kSameRow = 1.4;      ///< ratio of rows at which the ground must be seen
  // Farther than the ground.
  static constexpr double kSunkenShare = 0.3;  ///< of the points beside: higher ones differ less
  static constexpr double kBeside_px = 8;
  static constexpr double kTallest = 1.6;  ///< heights of the camera above the ground: a van
  // Nearer than the ground.
  static constexpr double kEdge = 0.03;       ///< [heights] this close to the lower edge it is cut off
  static constexpr double kFlat = 0.5;        ///< inverse depth ~ rows^slope: 0 for upright, 1 for ground
  static constexpr double kFoot = 0.1;        ///< quantile of a group's ratios
  static constexpr double kInFront = 1.25;    ///< ratio of inverse depths from which a point hides others
  static constexpr double kBelowFoot_px = 8;  ///< beneath is what the foot's own patch does not cover
  static constexpr std::size_t kLarge = 12;   ///< points of a group that needs no ground beneath it
  /// Ratio of a lower end at a quarter of the camera's height: the bumper of a parked car whose wheels show
  /// nothing.
  static constexpr double kHighestEnd = 4.0 / 3;

  using Members = Span<const int>;
  const GroundedPoint& point(int m) const { return (*points_)[static_cast<std::size_t>(m)]; }
  double below(const GroundedPoint& p) const { return ground()->below(p.at.x, p.at.y); }
  double ratio(const GroundedPoint& p) const { return p.at.inverse_depth / (ground()->scale * below(p)); }
  bool is_ground(const GroundedPoint& p) const {
    const double r = ratio(p);
    return below(p) > 0 && r > kLeastGround && r < kMostGround;
  }

  bool find_ground();
  std::optional<double> farther(std::size_t k);
  bool ground_seen_at(double below_px) const;
  /// The lower part of a body that seems to be beneath the ground speaks for all of it.
  void extend_sunken_part(const Members& group);

  std::optional<double> nearer(const Members& group);
  /// The lower end of the group, its extent, and its ratio to the ground.
  struct Foot {
    double left_px, right_px, y_px, ratio;
  };
  std::optional<Foot> foot_of(const Members& group);
  /// Number of ground points between the lower end and the place where it would stand, less the points in
  /// front.
  int ground_beneath(const Foot& foot) const;

  GroundPlaneFinder finder_;
  Expiring<GroundPlane> ground_;
  double ground_s_ = 0;  ///< the gap in whose steps its scale is
  GroundView view_;
  const std::vector<GroundedPoint>* points_ = nullptr;
  const FlowGroups* groups_ = nullptr;
  std::vector<GroundPoint> shown_;
  std::vector<std::optional<double>> sigmas_;
  std::vector<double> values_, rows_;
  std::vector<double> ground_rows_;  ///< [px] below the horizon, where ground is seen; sorted
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/ground_contact-inl.hpp>
#endif
