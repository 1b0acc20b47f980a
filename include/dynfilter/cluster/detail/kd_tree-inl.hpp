// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/cluster/kd_tree.hpp>

#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE void KdTree::build(Span<const cv::Point3f> points) {
  items_.clear();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (detail::finite(points[i])) items_.push_back({points[i], static_cast<std::int32_t>(i)});
  nodes_.clear();
  if (!items_.empty()) split(0, static_cast<std::uint32_t>(items_.size()));
}

DYNFILTER_INLINE void KdTree::nearest(const cv::Point3f& query, std::size_t k,
                                      std::vector<Neighbour>& out) const {
  out.clear();
  if (k == 0 || nodes_.empty() || !detail::finite(query)) return;
  out.assign(k, Neighbour());
  Best<Neighbour> best{out.data(), out.data() + k - 1};
  search_all(query, best);
  out.erase(std::find_if(out.begin(), out.end(), [](const Neighbour& n) { return n.index < 0; }), out.end());
}

DYNFILTER_INLINE KdTree::Neighbour KdTree::nearest_within(const cv::Point3f& query, double radius_m) const {
  Neighbour found;
  if (nodes_.empty() || !detail::finite(query)) return found;
  found.squared_distance = just_above(detail::squared_radius(radius_m));
  Best<Neighbour> best{&found, &found};
  search_all(query, best);
  return found.index < 0 ? Neighbour() : found;
}

inline std::uint32_t KdTree::split(std::uint32_t begin, std::uint32_t end) {
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({begin, end, 0, 0, 0});
  if (end - begin <= kLeaf) return self;
  const int axis = widest_axis(begin, end);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(
      items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
      [axis](const Item& a, const Item& b) { return on_axis(a.point, axis) < on_axis(b.point, axis); });
  const float cut = on_axis(items_[middle].point, axis);
  split(begin, middle);
  const std::uint32_t right = split(middle, end);
  nodes_[self] = {begin, end, right, axis, cut};
  return self;
}

inline int KdTree::widest_axis(std::uint32_t begin, std::uint32_t end) const {
  cv::Point3f low = items_[begin].point, high = low;
  for (std::uint32_t i = begin; i < end; ++i) {
    const cv::Point3f& p = items_[i].point;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const cv::Point3f width = high - low;
  if (width.x >= width.y && width.x >= width.z) return 0;
  return width.y >= width.z ? 1 : 2;
}

}  // namespace dynfilter
