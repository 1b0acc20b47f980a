// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/parameters.hpp>

namespace dynfilter {

/// Verification of a tracked point.
/// LK's own status accepts 987 of 1000 points between unrelated images.
/// See docs/explanation/correspondence.md for figures of each check.
enum class FlowCheck {
  None,      ///< LK's status and the borders only
  Residual,  ///< also requires similar patches
  /// Also requires that tracking back returns to the start; most reliable, at twice the cost.
  ForwardBackward
};

/// Lucas-Kanade implementation. Own is correspondence/lucas_kanade.hpp.
/// Falls back to OpenCV's for window sizes and processors that Own does not support.
enum class FlowEngine { Own, OpenCv };

struct FlowParams {
  FlowEngine engine = FlowEngine::Own;
  int window_px = 21;
  int levels = 3;
  int max_iterations = 30;
  double epsilon_px = 0.01;
  double min_eigenvalue = 1e-4;
  FlowCheck check = FlowCheck::ForwardBackward;
  double max_residual = 0.3;
  double max_forward_backward_px = 1.0;
  int border_px = 5;

  static const FieldTable<FlowParams>& fields() {
    static const FieldTable<FlowParams> table{
        choice("engine", &FlowParams::engine, {{"own", FlowEngine::Own}, {"opencv", FlowEngine::OpenCv}},
               "Lucas-Kanade implementation; both are equally accurate, own takes less than half the time"),
        integer("window_px", &FlowParams::window_px, "px", {5, 63}, "side of the square patch"),
        integer("levels", &FlowParams::levels, "", {0, 8},
                "pyramid levels above the image; each doubles the largest motion that can be tracked"),
        integer("max_iterations", &FlowParams::max_iterations, "", {1, 100}, "maximum iterations per level"),
        real("epsilon_px", &FlowParams::epsilon_px, "px", {1e-4, 1}, "step length that ends the iterations"),
        real("min_eigenvalue", &FlowParams::min_eigenvalue, "", {0, 1},
             "smallest eigenvalue of the gradient matrix; patches with less texture are not tracked"),
        choice("check", &FlowParams::check,
               {{"none", FlowCheck::None},
                {"residual", FlowCheck::Residual},
                {"forward_backward", FlowCheck::ForwardBackward}},
               "verification of a tracked point"),
        real("max_residual", &FlowParams::max_residual, "", {0, 2},
             "largest 1 - normalised cross-correlation of the patches, for any check except none; 2 disables "
             "it"),
        real("max_forward_backward_px", &FlowParams::max_forward_backward_px, "px", {0, 100},
             "largest distance from the start after tracking back, for check forward_backward"),
        integer("border_px", &FlowParams::border_px, "px", {0, 1000},
                "smallest distance from the image border, in both frames"),
    };
    return table;
  }
};

}  // namespace dynfilter
