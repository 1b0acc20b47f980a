// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>

namespace dynfilter {

/// Verification of a tracked point. LK's own status accepts 987 of 1000 points between unrelated images. See
/// docs/explanation/correspondence.md for figures of each check.
enum class FlowCheck {
  None,      ///< LK's status and the borders only
  Residual,  ///< also requires similar patches
  /// Also requires that tracking back returns to the start; most reliable, at up to twice the cost.
  ForwardBackward
};

/// Lucas-Kanade implementation.
/// For window sizes that it does not support, Guided falls back to Own, and Own to OpenCV's.
enum class FlowEngine {
  Guided,  ///< correspondence/guided_flow.hpp: coarse levels on a grid, points on level 0; windows 12 to 16
  Own,     ///< correspondence/lucas_kanade.hpp: every point on every level
  OpenCv   ///< cv::calcOpticalFlowPyrLK
};

struct FlowParams {
  FlowEngine engine = FlowEngine::Own;
  int window_px = 21;
  int levels = 3;
  int max_iterations = 30;
  double epsilon_px = 0.01;
  /// Verification of a tracked point. Not a key: code sets it.
  FlowCheck check = FlowCheck::ForwardBackward;
  /// Smallest distance from the image border, in both frames. Not a key: code sets it.
  int border_px = 5;

  /// The fast flow of the default pipelines: engine Guided, and the settings that it was measured with.
  static FlowParams guided();

  static const FieldTable<FlowParams>& fields();
};

struct DescriptorMatchParams {
  double search_radius_px = 50;
  /// Largest octave difference of the two features. Not a key: code sets it.
  int max_octave_difference = 1;
  int max_distance_bits = 64;  ///< Largest Hamming distance of a match. Not a key: code sets it.
  /// Largest ratio of the best to the second-best distance. Not a key: code sets it.
  double max_ratio = 0.9;

  static const FieldTable<DescriptorMatchParams>& fields();
};

/// Source of correspondences.
/// Auto uses the host's matches if it provides them, else flow on the grey image, else descriptors.
enum class CorrespondenceSource { Auto, Host, Flow, Descriptors };

/// Where correspondences come from, and which depths count.
struct CorrespondenceParams {
  CorrespondenceSource source = CorrespondenceSource::Auto;
  double max_depth_m = 8.0;
  int threads = 1;
  FlowParams flow;
  DescriptorMatchParams descriptors;

  static const FieldTable<CorrespondenceParams>& fields();
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/correspondence_params-inl.hpp>
#endif
