// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/depth_split.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Detects jumps between two surfaces of a depth image.
/// Neighbours differ by more than a share of the depth and three standard deviations of its noise.
class DepthJump {
 public:
  /// As a share of the depth.
  explicit DepthJump(double max_step_share) : share_(static_cast<float>(max_step_share)) {}

  /// Depths [m], 0: no depth. A pixel without depth is never part of a jump.
  /// Branchless, so that compilers vectorise it.
  DYNFILTER_AS_CALLER bool operator()(float a_m, float b_m) const {
    const float nearer = a_m < b_m ? a_m : b_m;
    const float limit = base_m_ + nearer * (share_ + quadratic_per_m_ * nearer);
    return (static_cast<int>(nearer > 0) & static_cast<int>(std::abs(a_m - b_m) > limit)) != 0;
  }

 private:
  float share_;
  float base_m_ = 3 * static_cast<float>(DepthNoise().base_m),
        quadratic_per_m_ = 3 * static_cast<float>(DepthNoise().quadratic_per_m);
};

/// The pixels of the object in a detector's box, from depth only.
///
/// The nearer side of the box (nearer_surface_m) is divided into parts at depth jumps. The core is the part
/// that fills most of the middle of the box. The body is the core and all parts with a mean depth within 0.6
/// m of it. These are, for example, legs below a desk or an arm in front of the chest. Pixels of the farther
/// side up to 0.6 m behind the core also belong to it, such as a hand. Parts that are farther away in depth,
/// such as a desk or a shelf, are excluded. If no part fills a tenth of the middle, an occluder is in front
/// of the body. The farther side is then split again, until a part fills the middle or no split is left. In
/// the latter case, the body is the whole first nearer side.
///
/// A missed pixel remains in the map as a ghost, so this class includes all that may be the body.
///
/// Blind to: objects that touch the body without a jump, and a person behind it.
/// Cost: linear in the box, about 5 ns per pixel and split. Buffers are reused.
class BoxBody {
 public:
  /// `depth_m`: CV_32FC1, 0: no depth. `box` is inside it.
  /// `body` becomes CV_8UC1 of the box's size, 255 on the body.
  void run(const cv::Mat& depth_m, const cv::Rect& box, cv::Mat& body);

 private:
  static constexpr double kReachM = 0.6;  ///< of an arm
  static constexpr double kMinMiddleShare = 0.1;
  static constexpr double kMaxStepShare = 0.02;
  struct Part {
    std::uint32_t parent;  ///< a smaller number, or the part itself
    std::size_t pixels, in_the_middle;
    double sum_m;
    bool body;

    double mean_m() const { return sum_m / static_cast<double>(pixels); }
  };

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  /// Marks the parts of the body.
  /// Returns the depth up to which pixels of the farther side belong to it; 0: none.
  float find_body(const cv::Mat& depth);
  /// Far end of the nearer side among the depths beyond `beyond_m`.
  float nearer_side_from(const cv::Mat& depth, float beyond_m);

  /// Part 0 contains pixels without depth and those of the farther side.
  void find_parts(const cv::Mat& depth, float farthest_m);
  std::uint32_t part_of(const float* z, const float* above, int x, int y);
  std::uint32_t root(std::uint32_t part) {
    while (parts_[part].parent != part) part = parts_[part].parent = parts_[parts_[part].parent].parent;
    return part;
  }
  std::uint32_t join(std::uint32_t a, std::uint32_t b) {
    return a < b ? parts_[b].parent = a : parts_[a].parent = b;
  }
  void add_up(const cv::Mat& depth);

  /// The part that fills most of the middle of the box; 0: no part fills enough.
  std::size_t core_part() const;
  float choose_parts(std::size_t core) {
    const double core_m = parts_[core].mean_m();
    for (Part& part : parts_) part.body = part.pixels > 0 && std::abs(part.mean_m() - core_m) <= kReachM;
    return static_cast<float>(core_m + kReachM);
  }

  DepthJump jump_{kMaxStepShare};
  int width_ = 0;
  cv::Rect middle_;
  std::vector<float> inverse_;
  std::vector<std::uint32_t> part_;  ///< of each pixel
  std::vector<Part> parts_;
};

inline void BoxBody::run(const cv::Mat& depth_m, const cv::Rect& box, cv::Mat& body) {
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

}  // namespace dynfilter::mapping
