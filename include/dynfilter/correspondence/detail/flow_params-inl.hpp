// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/flow_params.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>

namespace dynfilter {

DYNFILTER_INLINE FlowParams FlowParams::guided() {
  FlowParams params;
  params.engine = FlowEngine::Guided;
  params.window_px = 16;
  params.levels = 4;
  params.max_iterations = 4;  // more follow the noise of blurred patches
  params.epsilon_px = 0.05;
  return params;
}

DYNFILTER_INLINE const FieldTable<FlowParams>& FlowParams::fields() {
  static const FieldTable<FlowParams> table{
      choice("engine", &FlowParams::engine,
             {{"guided", FlowEngine::Guided}, {"own", FlowEngine::Own}, {"opencv", FlowEngine::OpenCv}},
             "Lucas-Kanade implementation; guided shares the coarse levels between points (windows of 12 to "
             "16 px, else own), own has OpenCV's results"),
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

}  // namespace dynfilter
