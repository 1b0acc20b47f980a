// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/correspondence_params.hpp>

#include <dynfilter/core/inline.hpp>

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
  };
  return table;
}

DYNFILTER_INLINE const FieldTable<DescriptorMatchParams>& DescriptorMatchParams::fields() {
  using P = DescriptorMatchParams;
  static const FieldTable<P> table{
      real("search_radius_px", &P::search_radius_px, "px", {0.5, 10000},
           "radius around the expected position that is searched"),
  };
  return table;
}

DYNFILTER_INLINE const FieldTable<CorrespondenceParams>& CorrespondenceParams::fields() {
  using P = CorrespondenceParams;
  static const FieldTable<P> table{
      choice("source", &P::source,
             {{"auto", CorrespondenceSource::Auto},
              {"host", CorrespondenceSource::Host},
              {"flow", CorrespondenceSource::Flow},
              {"descriptors", CorrespondenceSource::Descriptors}},
             "source of correspondences; auto uses the host's matches, else flow, else descriptors"),
      real("max_depth_m", &P::max_depth_m, "m", {0.1, 1000},
           "largest depth that is used; larger depths count as no depth"),
      integer("threads", &P::threads, "", {1, 64},
              "how many of OpenCV's threads the guided flow may use; results do not depend on it"),
      group("flow", &P::flow, "parameters of pyramidal Lucas-Kanade flow"),
      group("descriptors", &P::descriptors, "parameters of windowed descriptor matching"),
  };
  return table;
}

}  // namespace dynfilter
