// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/correspondence_params.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

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
      real("max_depth_edge", &P::max_depth_edge, "", {0, 10},
           "largest relative depth difference to neighbouring pixels; beyond it, a pixel has no depth"),
      integer("threads", &P::threads, "", {1, 64},
              "how many of OpenCV's threads the guided flow may use; results do not depend on it"),
      group("flow", &P::flow, "parameters of pyramidal Lucas-Kanade flow"),
      group("descriptors", &P::descriptors, "parameters of windowed descriptor matching"),
  };
  return table;
}

}  // namespace dynfilter
