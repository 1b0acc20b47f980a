// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/depth_jump.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter::mapping {

/// The pixels of the object in a detector's box, from depth only.
///
/// The nearer side of the box (nearer_surface_m) is divided into parts at depth jumps.
/// The core is the part that fills most of the middle of the box.
/// The body is the core and all parts with a mean depth within 0.6 m of it.
/// These are, for example, legs below a desk or an arm in front of the chest.
/// Pixels of the farther side up to 0.6 m behind the core also belong to it, such as a hand.
/// Parts that are farther away in depth, such as a desk or a shelf, are excluded.
/// If no part fills a tenth of the middle, an occluder is in front of the body.
/// The farther side is then split again, until a part fills the middle or no split is left.
/// In the latter case, the body is the whole first nearer side.
///
/// semantic/box_masks.hpp computes tighter masks.
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
  std::uint32_t root(std::uint32_t part);
  std::uint32_t join(std::uint32_t a, std::uint32_t b) {
    return a < b ? parts_[b].parent = a : parts_[a].parent = b;
  }
  void add_up(const cv::Mat& depth);

  /// The part that fills most of the middle of the box; 0: no part fills enough.
  std::size_t core_part() const;
  float choose_parts(std::size_t core);

  DepthJump jump_{kMaxStepShare};
  int width_ = 0;
  cv::Rect middle_;
  std::vector<float> inverse_;
  std::vector<std::uint32_t> part_;  ///< of each pixel
  std::vector<Part> parts_;
};

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/box_body-inl.hpp>
#endif
