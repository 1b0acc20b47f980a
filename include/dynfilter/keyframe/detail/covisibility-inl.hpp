// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/keyframe/covisibility.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/keyframe/frame_summary.hpp>

namespace dynfilter {

DYNFILTER_INLINE Graph covisibility_graph(const std::vector<const std::vector<std::int64_t>*>& points,
                                          std::size_t min_shared, double min_share) {
  Graph graph(points.size());
  for (Graph::Vertex a = 0; a < points.size(); ++a)
    for (Graph::Vertex b = a + 1; b < points.size(); ++b) {
      const std::size_t shared = shared_points(*points[a], *points[b]);
      const auto fewer = static_cast<double>(std::min(points[a]->size(), points[b]->size()));
      if (shared >= std::max<std::size_t>(1, min_shared) && static_cast<double>(shared) >= min_share * fewer)
        graph.connect(a, b);
    }
  return graph;
}

}  // namespace dynfilter
