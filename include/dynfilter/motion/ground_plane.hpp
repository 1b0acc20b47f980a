// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace dynfilter {

/// The plane that the camera drives along, in image coordinates.
/// (x, y) are pixels right of and below the focus of expansion.
/// A point of the plane has inverse depth `scale * below(x, y)` in units of the camera's step.
/// The horizon of the plane runs through the focus of expansion, because the camera moves along the plane.
struct GroundPlane {
  double scale = 0;
  double tilt = 0;  ///< tilt of the horizon [rad]; positive if the ground is higher on the right

  double below(double x, double y) const { return y + tilt * x; }
};

/// A point for GroundPlaneFinder. Inverse depth is in units of the camera's step.
struct GroundPoint {
  double x = 0, y = 0;  ///< pixels from the focus of expansion, y down
  double inverse_depth = 0;
  int cell = 0;  ///< image cell; the points of one cell share one vote
};

/// Finds the ground among points that appear static.
/// The ground is the lowest plane with much support, because nothing static is below it.
/// For each of a few tilts, the ratios inverse_depth / below() are sorted.
/// The search from below selects the window [r, 1.2 r] with votes from most cells.
/// Cost: about 0.2 ms for 1000 points.
class GroundPlaneFinder {
 public:
  struct Options {
    double min_below_px = 30;      ///< points closer to the horizon carry little information
    double window = 1.2;           ///< ratio of the upper to the lower bound of the window
    double min_support = 3;        ///< cells
    double min_share = 0.2;        ///< smallest share of all votes below the horizon
    double min_log_spread = 0.25;  ///< smallest log spread of the image rows of the ground's points
    double share_of_best =
        0.5;        ///< the ground is the lowest window with this share of the best window's support
    int tilts = 4;  ///< number of tilts to either side, in steps of 0.02 rad
  };

  std::optional<GroundPlane> find(const std::vector<GroundPoint>& points, const Options& options);

 private:
  struct Ratio {
    double value, weight;
    double log_below;
    bool operator<(const Ratio& o) const {
      return value < o.value || (value == o.value && weight < o.weight);
    }
  };

  /// Sets the scale. Returns its support, 0 if no scale is found.
  double fit_scale(const std::vector<GroundPoint>& points, const Options& options, GroundPlane& plane);

  /// True if the window that starts here spans near and far rows.
  /// A wall ahead has one depth, so its rows have different ratios.
  bool recedes(std::size_t first, const Options& options) const;

  void collect_ratios(const std::vector<GroundPoint>& points, const Options& options,
                      const GroundPlane& plane);

  double weighted_median_from(std::size_t first) const;

  std::vector<Ratio> ratios_;
  std::vector<double> support_;
  std::vector<int> in_cell_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/ground_plane-inl.hpp>
#endif
