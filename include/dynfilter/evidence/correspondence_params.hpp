// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/correspondence/descriptor_match_params.hpp>
#include <dynfilter/correspondence/flow_params.hpp>

namespace dynfilter {

/// Source of correspondences.
/// Auto uses the host's matches if it provides them, else flow on the grey image, else descriptors.
enum class CorrespondenceSource { Auto, Host, Flow, Descriptors };

/// Where correspondences come from, and which depths count.
struct CorrespondenceParams {
  CorrespondenceSource source = CorrespondenceSource::Auto;
  double max_depth_m = 8.0;
  double max_depth_edge = 0.06;
  int threads = 1;
  FlowParams flow;
  DescriptorMatchParams descriptors;

  static const FieldTable<CorrespondenceParams>& fields();
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/correspondence_params-inl.hpp>
#endif
