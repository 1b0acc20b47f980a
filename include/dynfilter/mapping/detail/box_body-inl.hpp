// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/box_body.hpp>

#include <cmath>
#include <dynfilter/cluster/depth_split.hpp>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::mapping {

DYNFILTER_INLINE void BoxBody::run(const cv::Mat& depth_m, const cv::Rect& box, cv::Mat& body) {
  const cv::Mat depth = depth_m(box);
  const float behind_m = find_body(depth);
  body.create(box.size(), CV_8UC1);
  for (int y = 0; y < box.height; ++y) {
    const std::uint32_t* part = &part_[index(0, y)];
    const float* z = depth.ptr<float>(y);
    std::uint8_t* out = body.ptr<std::uint8_t>(y);
    for (int x = 0; x < box.width; ++x) {
      const bool farther = part[x] == 0 && z[x] > 0 && z[x] <= behind_m;
      out[x] = parts_[part[x]].body || farther ? 255 : 0;
    }
  }
}

inline float BoxBody::find_body(const cv::Mat& depth) {
  const float nearer_side_m = nearer_side_from(depth, 0);
  for (float farthest_m = nearer_side_m;;) {
    find_parts(depth, farthest_m);
    if (const std::size_t core = core_part()) return choose_parts(core);
    const float next_m = nearer_side_from(depth, farthest_m);
    if (std::isinf(next_m)) break;
    farthest_m = next_m;
  }
  find_parts(depth, nearer_side_m);
  for (std::size_t p = 1; p < parts_.size(); ++p) parts_[p].body = true;
  return 0;
}

inline float BoxBody::nearer_side_from(const cv::Mat& depth, float beyond_m) {
  inverse_.clear();
  for (int y = 0; y < depth.rows; y += 4)
    for (int x = 0; x < depth.cols; x += 4)
      if (depth.at<float>(y, x) > beyond_m) inverse_.push_back(1 / depth.at<float>(y, x));
  return static_cast<float>(nearer_surface_m(inverse_));
}

inline void BoxBody::find_parts(const cv::Mat& depth, float farthest_m) {
  width_ = depth.cols;
  middle_ = cv::Rect(depth.cols / 4, depth.rows / 10, depth.cols - 2 * (depth.cols / 4), depth.rows / 2);
  part_.assign(depth.total(), 0);
  parts_.assign(1, {0, 0, 0, 0, false});
  for (int y = 0; y < depth.rows; ++y) {
    const float* z = depth.ptr<float>(y);
    const float* above = depth.ptr<float>(y > 0 ? y - 1 : 0);
    for (int x = 0; x < depth.cols; ++x)
      if (z[x] > 0 && z[x] <= farthest_m) part_[index(x, y)] = part_of(z, above, x, y);
  }
  add_up(depth);
}

inline std::uint32_t BoxBody::part_of(const float* z, const float* above, int x, int y) {
  const std::uint32_t left = x > 0 && !jump_(z[x], z[x - 1]) ? part_[index(x - 1, y)] : 0;
  const std::uint32_t up = y > 0 && !jump_(z[x], above[x]) ? part_[index(x, y - 1)] : 0;
  if (left != 0 && up != 0) return left == up ? left : join(root(left), root(up));
  if (left != 0 || up != 0) return left | up;
  const auto made = static_cast<std::uint32_t>(parts_.size());
  parts_.push_back({made, 0, 0, 0, false});
  return made;
}

inline std::uint32_t BoxBody::root(std::uint32_t part) {
  while (parts_[part].parent != part) part = parts_[part].parent = parts_[parts_[part].parent].parent;
  return part;
}

inline void BoxBody::add_up(const cv::Mat& depth) {
  for (int y = 0; y < depth.rows; ++y) {
    const float* z = depth.ptr<float>(y);
    for (int x = 0; x < depth.cols; ++x) {
      std::uint32_t& part = part_[index(x, y)];
      if (part == 0) continue;
      part = root(part);
      ++parts_[part].pixels;
      parts_[part].in_the_middle += middle_.contains({x, y}) ? 1U : 0U;
      parts_[part].sum_m += static_cast<double>(z[x]);
    }
  }
}

inline std::size_t BoxBody::core_part() const {
  std::size_t core = 0;
  for (std::size_t p = 1; p < parts_.size(); ++p)
    if (parts_[p].in_the_middle > parts_[core].in_the_middle) core = p;
  const auto middle = static_cast<double>(middle_.area());
  return static_cast<double>(parts_[core].in_the_middle) >= kMinMiddleShare * middle ? core : 0;
}

inline float BoxBody::choose_parts(std::size_t core) {
  const double core_m = parts_[core].mean_m();
  for (Part& part : parts_) part.body = part.pixels > 0 && std::abs(part.mean_m() - core_m) <= kReachM;
  return static_cast<float>(core_m + kReachM);
}

}  // namespace dynfilter::mapping
