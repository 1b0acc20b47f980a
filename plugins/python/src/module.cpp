// SPDX-License-Identifier: MIT
#include <dynfilter/version.hpp>

#include "bindings.hpp"

PYBIND11_MODULE(_core, module) {
  using namespace dynfilter::python;
  module.doc() = "The compiled part of dynfilter. Import `dynfilter` instead.";
  module.attr("__version__") = DYNFILTER_VERSION;
  bind_errors(module);
  bind_frame(module);
  bind_evidence(module);
  bind_registry(module);
  bind_verdict(module);
  bind_pipeline(module);
  bind_exact_scene(module);
  bind_sequences(module);
  bind_evaluation(module);
  bind_mapping(module);
  bind_odometry(module);
}
