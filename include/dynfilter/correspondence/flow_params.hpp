// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/field_table.hpp>

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

  static const FieldTable<FlowParams>& fields();
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/flow_params-inl.hpp>
#endif
