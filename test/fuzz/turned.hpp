// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <utility>
#include <vector>

#include "frames.hpp"

namespace fuzz {

/// Turns the frames of a sequence into others whose verdicts are known from theirs.
class Turner {
 public:
  /// False from the first frame on for which no relation is promised.
  bool comparable() const { return comparable_; }

  /// Reverses the order of the features. Returns the new place of each.
  std::vector<std::size_t> permute(OwnedFrame& f) {
    const std::size_t n = f.size();
    if (has_ties(f)) comparable_ = false;
    std::vector<std::size_t> place(n);
    for (std::size_t i = 0; i < n; ++i) place[i] = n - 1 - i;
    // Matches may name the frame itself, since it can be judged again. Of two frames with one id, either may
    // be meant.
    const bool is_new = counts_.emplace(f.id, n).second;
    if (!is_new && counts_[f.id] != n) comparable_ = false;
    if (f.match_index.size() == n) redirect(f);
    turn(f.keypoints, n), turn(f.undistorted, n), turn(f.depth_m, n), turn(f.right_u_px, n);
    turn(f.map_point_ids, n), turn(f.map_points, n), turn(f.match_index, n);
    turn(f.keyframe_points, n);
    if (static_cast<std::size_t>(f.descriptors.rows) == n && n > 0) f.descriptors = flipped(f.descriptors, 0);
    return place;
  }

  /// Left becomes right in `f`. Only for stages without a model, a match or an image.
  /// The boxes of both frames end between pixels, since a box has its left border and not its right one.
  void mirror(OwnedFrame& original, OwnedFrame& f) {
    const int width = f.grey.empty() ? 0 : f.grey.cols;
    if (width == 0 || f.grey.type() != CV_8UC1) return void(comparable_ = false);
    for (const cv::KeyPoint& k : f.keypoints)
      if (!on_lattice(k.pt.x) || k.pt.x < 0 || k.pt.x >= static_cast<float>(width))
        comparable_ = false;  // a keypoint at x = width belongs to the last column
    for (const dynfilter::Detection& d : f.boxes)
      if (!on_lattice(d.box.x) || !on_lattice(d.box.width)) comparable_ = false;
    if (f.labels.size() != f.grey.size()) comparable_ = false;     // scaling rounds to one side
    if (f.boxes_id != -1 || f.mask_id != -1) comparable_ = false;  // carried by matches
    if (!comparable_) return;
    const auto last = static_cast<float>(width - 1);
    for (cv::KeyPoint& k : f.keypoints) k.pt.x = last - k.pt.x;
    for (cv::KeyPoint& k : f.undistorted) k.pt.x = last - k.pt.x;
    for (dynfilter::Detection& d : original.boxes) d.box.x -= 0.5F;
    for (dynfilter::Detection& d : f.boxes) {
      d.box.x -= 0.5F;
      d.box.x = last - d.box.x - d.box.width;
      if (!d.mask.empty()) d.mask = flipped(d.mask, 1);
    }
    f.labels = flipped(f.labels, 1);
  }

 private:
  /// The pixels of an OwnedFrame may be another frame's, too.
  static cv::Mat flipped(const cv::Mat& image, int axis) {
    cv::Mat out;
    cv::flip(image, out, axis);
    return out;
  }
  static bool on_lattice(float x) { return std::abs(x) < 1000 && std::floor(x) == x; }

  /// Two features that nothing distinguishes may change their roles.
  static bool has_ties(const OwnedFrame& f) {
    std::set<std::pair<float, float>> places;
    std::set<std::int64_t> ids;
    for (const cv::KeyPoint& k : f.keypoints)
      if (!(std::isfinite(k.pt.x) && std::isfinite(k.pt.y)) || !places.insert({k.pt.x, k.pt.y}).second)
        return true;
    places.clear();
    for (const cv::KeyPoint& k : f.undistorted)
      if (!(std::isfinite(k.pt.x) && std::isfinite(k.pt.y)) || !places.insert({k.pt.x, k.pt.y}).second)
        return true;
    for (const std::int64_t id : f.map_point_ids)
      if (id >= 0 && !ids.insert(id).second) return true;
    return false;
  }
  void redirect(OwnedFrame& f) const {
    const auto reference = counts_.find(f.match_id);
    if (reference == counts_.end()) return;
    const auto n = static_cast<std::int64_t>(reference->second);
    for (std::int32_t& m : f.match_index)
      if (m >= 0 && m < n) m = static_cast<std::int32_t>(n - 1 - m);
  }
  template <class T>
  static void turn(std::vector<T>& values, std::size_t n) {
    if (values.size() == n) std::reverse(values.begin(), values.end());
  }

  bool comparable_ = true;
  std::map<std::int64_t, std::size_t> counts_;
};

}  // namespace fuzz
