// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <dynfilter/keyframe/graph.hpp>
#include <vector>

namespace dynfilter {

/// Connects two frames that share at least `min_shared` points.
/// They must also share at least `min_share` of the smaller point list.
/// The lists are ascending. Cost: n^2 merges.
Graph covisibility_graph(const std::vector<const std::vector<std::int64_t>*>& points, std::size_t min_shared,
                         double min_share = 0);

inline Graph covisibility_graph(const std::vector<const std::vector<std::int64_t>*>& points,
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
