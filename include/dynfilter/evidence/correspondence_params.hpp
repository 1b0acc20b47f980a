// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/parameters.hpp>
#include <dynfilter/correspondence/descriptor_match_params.hpp>
#include <dynfilter/correspondence/flow_params.hpp>
#include <string>

namespace dynfilter {

/// Source of correspondences.
/// Auto uses the host's matches if it provides them, else flow on the grey image, else descriptors.
enum class CorrespondenceSource { Auto, Host, Flow, Descriptors };

/// Where correspondences come from, and which depths count.
struct CorrespondenceParams {
  CorrespondenceSource source = CorrespondenceSource::Auto;
  double max_depth_m = 8.0;
  double max_depth_edge = 0.06;
  FlowParams flow;
  DescriptorMatchParams descriptors;

  static const FieldTable<CorrespondenceParams>& fields() {
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
        real("max_depth_edge", &P::max_depth_edge, "", {0, 10},
             "largest relative depth difference to neighbouring pixels; beyond it, a pixel has no depth"),
        group("flow", &P::flow, "parameters of pyramidal Lucas-Kanade flow"),
        group("descriptors", &P::descriptors, "parameters of windowed descriptor matching"),
    };
    return table;
  }
};

}  // namespace dynfilter
