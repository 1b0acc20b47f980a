// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/simd.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>
#include <vector>

namespace dynfilter::detail {

/// A loop's body for cv::parallel_for_, which copies and allocates a std::function otherwise.
/// It refers to `work`.
template <class Work>
class RangeBody : public cv::ParallelLoopBody {
 public:
  explicit RangeBody(const Work& work) : work_(work) {}
  void operator()(const cv::Range& range) const override { work_(range); }

 private:
  const Work& work_;
};

/// Calls work(begin, end) on ranges that cover [0, count), on at most `threads` of OpenCV's threads.
template <class Work>
void in_ranges(int count, int threads, const Work& work) {
  if (threads <= 1) return work(0, count);
  const auto part = [&](const cv::Range& range) { work(range.start, range.end); };
  cv::parallel_for_({0, count}, RangeBody(part), threads);
}

/// Sums 1 4 6 4 1 over the pixels around every second one of a row, plus 8 for rounding. Reads two pixels on
/// either side of it.
template <int kLanes>
DYNFILTER_AS_CALLER inline void binomial_across(const std::uint8_t* from, int count, std::uint16_t* to) {
  using Pairs = Integers<std::uint16_t, 2 * kLanes>;  // of pixels, the even one first
  constexpr bool kLittleEndian = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
  static constexpr std::uint16_t kRound[16] = {8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8, 8};
  const Pairs round = Pairs::load(kRound);
  int x = 0;
  for (; kLittleEndian && x + 2 * kLanes <= count; x += 2 * kLanes) {
    Pairs left, middle, right;
    load_lane(from + 2 * x - 2, left.v), load_lane(from + 2 * x, middle.v),
        load_lane(from + 2 * x + 2, right.v);
    const Pairs even = (middle << 8) >> 8;
    (round + ((left << 8) >> 8) + ((right << 8) >> 8) + (((left >> 8) + (middle >> 8) + even) << 2) +
     (even << 1))
        .store(to + x);
  }
  for (; x < count; ++x) {
    const std::uint8_t* p = from + 2 * x;
    to[x] = static_cast<std::uint16_t>(8 + p[-2] + p[2] + 4 * (p[-1] + p[1]) + 6 * p[0]);
  }
}

/// The same over five rows of sums.
template <int kLanes>
DYNFILTER_AS_CALLER inline void binomial_down(const std::uint16_t* const (&rows)[5], int count,
                                              std::uint8_t* to) {
  using Sums = Integers<std::uint16_t, 2 * kLanes>;
  int x = 0;
  for (; x + 2 * kLanes <= count; x += 2 * kLanes) {
    const auto r = [&](int k) DYNFILTER_AS_CALLER { return Sums::load(rows[k] + x); };
    const Sums sum = r(0) + r(4) + ((r(1) + r(3) + r(2)) << 2) + (r(2) << 1);
    store_lane(to + x, __builtin_convertvector(sum.v >> 8, Vector<std::uint8_t, 2 * kLanes>));
  }
  for (; x < count; ++x)
    to[x] = static_cast<std::uint8_t>(
        (rows[0][x] + rows[4][x] + 4 * (rows[1][x] + rows[3][x]) + 6 * rows[2][x]) >> 8);
}

/// cv::pyrDown, bit for bit, without its allocations. With AVX2 a pyramid takes half of the time.
/// `from` has a border of two pixels at least.
inline void halve(const cv::Mat& from, std::vector<std::uint16_t>& scratch, cv::Mat& to) {
  const auto width = static_cast<std::size_t>(to.cols);
  scratch.resize(5 * width);
  call_widest([&](auto lanes) DYNFILTER_AS_CALLER {
    const auto sums = [&](int row) {
      return scratch.data() + static_cast<std::size_t>((row + 5) % 5) * width;
    };
    for (int y = 0, next = -2; y < to.rows; ++y) {
      for (; next <= 2 * y + 2; ++next)
        binomial_across<lanes()>(from.data + next * static_cast<std::ptrdiff_t>(from.step), to.cols,
                                 sums(next));
      const std::uint16_t* const rows[5] = {sums(2 * y - 2), sums(2 * y - 1), sums(2 * y), sums(2 * y + 1),
                                            sums(2 * y + 2)};
      binomial_down<lanes()>(rows, to.cols, to.ptr(y));
    }
  });
}

/// Copies eight bytes in reverse.
inline void reverse_8(const std::uint8_t* from, std::uint8_t* to) {
  std::uint64_t eight;
  std::memcpy(&eight, from, sizeof(eight));
  eight = __builtin_bswap64(eight);
  std::memcpy(to, &eight, sizeof(eight));
}

/// cv::copyMakeBorder with BORDER_REFLECT_101 around a part of `image` that is there already. It is
/// `border_px` from the edges, 8 at least, and larger than that.
inline void reflect_border(cv::Mat& image, int border_px) {
  const int last = image.cols - 1 - border_px;
  for (int y = border_px; y < image.rows - border_px; ++y) {
    std::uint8_t* const row = image.ptr(y);
    for (int done = 0; done < border_px; done += 8) {
      const int k = std::min(done, border_px - 8);  // the last eight may be some of those before
      reverse_8(row + border_px + 1 + k, row + border_px - 8 - k);
      reverse_8(row + last - 8 - k, row + last + 1 + k);
    }
  }
  const auto width = static_cast<std::size_t>(image.cols);
  for (int k = 1; k <= border_px; ++k) {
    std::memcpy(image.ptr(border_px - k), image.ptr(border_px + k), width);
    std::memcpy(image.ptr(image.rows - 1 - border_px + k), image.ptr(image.rows - 1 - border_px - k), width);
  }
}

}  // namespace dynfilter::detail

namespace dynfilter {

/// A grey image pyramid for pyramidal LK. Each level has a border of one window, and derivatives if
/// requested. It owns a deep copy. Rebuilding for the same image size allocates nothing. It is move-only
/// because copies of cv::Mat share pixels. To keep several frames, use several objects and std::swap.
class ImagePyramid {
 public:
  ImagePyramid() = default;
  ImagePyramid(const ImagePyramid&) = delete;
  ImagePyramid& operator=(const ImagePyramid&) = delete;
  ImagePyramid(ImagePyramid&& other) noexcept { swap(other); }
  ImagePyramid& operator=(ImagePyramid&& other) noexcept {
    swap(other);
    return *this;
  }

  /// `grey` is CV_8UC1 of any size; any other type leaves the pyramid empty. `levels` counts the levels above
  /// the image; small images get fewer. OpenCV's tracker needs `derivatives`.
  void build(const cv::Mat& grey, int window_px, int levels, bool derivatives = true);

  /// Makes the pyramid empty and keeps its memory for the next build.
  void clear() { size_ = cv::Size(); }

  bool empty() const { return size_.empty(); }
  cv::Size size() const { return size_; }
  int window_px() const { return window_px_; }  ///< width of the windows that it was built for [px]
  /// Images as cv::calcOpticalFlowPyrLK takes them, alternating with derivatives if present.
  const std::vector<cv::Mat>& levels() const { return levels_; }
  /// The image itself, CV_8UC1; empty without one.
  cv::Mat image() const { return empty() ? cv::Mat() : levels_[0]; }

  /// True if flow can run between the two pyramids.
  bool fits(const ImagePyramid& other) const {
    return !empty() && size_ == other.size_ && window_px_ == other.window_px_ &&
           levels_.size() == other.levels_.size();
  }

  void swap(ImagePyramid& other) noexcept;  ///< exchanges the content without a copy

 private:
  /// Isolated: the border of a region must not contain pixels of the larger image.
  static constexpr int kBorder = cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED;
  void build_levels(const cv::Mat& grey, int levels);

  std::vector<cv::Mat> levels_, bordered_;  ///< inner parts, and whole ones
  std::vector<std::uint16_t> scratch_;
  cv::Size size_;
  int window_px_ = 0;
};

inline void ImagePyramid::build(const cv::Mat& grey, int window_px, int levels, bool derivatives) {
  if (grey.empty() || grey.type() != CV_8UC1 || window_px < 3 || levels < 0) {
    clear();
    return;
  }
  window_px_ = window_px;
  size_ = grey.size();
  if (!derivatives) return build_levels(grey, levels);
  cv::buildOpticalFlowPyramid(grey, levels_, {window_px, window_px}, levels, true, kBorder,
                              cv::BORDER_CONSTANT, false);
}

/// The same without derivatives.
inline void ImagePyramid::build_levels(const cv::Mat& grey, int levels) {
  cv::Size size = grey.size();
  levels_.clear();
  for (std::size_t k = 0; k <= static_cast<std::size_t>(levels); ++k) {
    if (k > 0 && (size.width <= window_px_ || size.height <= window_px_)) return;
    if (k == bordered_.size()) bordered_.emplace_back();
    bordered_[k].create(size.height + 2 * window_px_, size.width + 2 * window_px_, CV_8UC1);
    cv::Mat inner = bordered_[k](cv::Rect({window_px_, window_px_}, size));
    k > 0 ? detail::halve(levels_[k - 1], scratch_, inner) : grey.copyTo(inner);
    if (window_px_ >= 8 && std::min(size.width, size.height) > window_px_)
      detail::reflect_border(bordered_[k], window_px_);
    else
      cv::copyMakeBorder(inner, bordered_[k], window_px_, window_px_, window_px_, window_px_, kBorder);
    levels_.push_back(inner);
    size = {(size.width + 1) / 2, (size.height + 1) / 2};
  }
}

inline void ImagePyramid::swap(ImagePyramid& other) noexcept {
  std::swap(levels_, other.levels_);
  std::swap(bordered_, other.bordered_);
  std::swap(scratch_, other.scratch_);
  std::swap(size_, other.size_);
  std::swap(window_px_, other.window_px_);
}

}  // namespace dynfilter
