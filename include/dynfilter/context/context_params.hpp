// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/parameters.hpp>
#include <dynfilter/correspondence/descriptor_match.hpp>
#include <dynfilter/correspondence/flow.hpp>
#include <string>

namespace dynfilter {

/// Where correspondences come from. Auto: the host's matches if it hands some in, else flow on the grey
/// image, else descriptors.
enum class CorrespondenceSource { Auto, Host, Flow, Descriptors };

/// How the evidence that filters share is computed.
struct ContextParams {
  CorrespondenceSource source = CorrespondenceSource::Auto;
  double max_depth_m = 8.0;
  double max_depth_edge = 0.06;
  FlowParams flow;
  DescriptorMatchParams descriptors;

  static const FieldTable<ContextParams>& fields() {
    using P = ContextParams;
    static const FieldTable<P> table{
        choice("source", &P::source,
               {{"auto", CorrespondenceSource::Auto},
                {"host", CorrespondenceSource::Host},
                {"flow", CorrespondenceSource::Flow},
                {"descriptors", CorrespondenceSource::Descriptors}},
               "where correspondences come from; auto: the host's matches, else flow, else descriptors"),
        real("max_depth_m", &P::max_depth_m, "m", {0.1, 1000}, "farther depths count as none"),
        real("max_depth_edge", &P::max_depth_edge, "", {0, 10},
             "a pixel has no depth where its neighbours' differ by more than this share"),
        group("flow", &P::flow, "pyramidal LK flow"),
        group("descriptors", &P::descriptors, "windowed descriptor matching"),
    };
    return table;
  }
};

}  // namespace dynfilter
