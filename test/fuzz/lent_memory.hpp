// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace fuzz {

/// How a host holds its images.
enum class Host {
  Frees,  ///< cv::Mat headers around memory of its own, with padded rows, which it frees after the call
  Reuses  ///< cv::Mat with counted references, which it writes to again after the call
};

/// Memory that is promised for one call. Every array is an allocation of its exact size.
/// take_back() fills all of it with `garbage`. Host::Frees then frees it.
class LentMemory {
 public:
  LentMemory(Host host, std::uint8_t garbage) : host_(host), garbage_(garbage) {}
  LentMemory(const LentMemory&) = delete;
  LentMemory& operator=(const LentMemory&) = delete;
  ~LentMemory() {
    take_back();
    free_blocks();
  }

  void* bytes(std::size_t n) {
    blocks_.push_back({std::malloc(n > 0 ? n : 1), n});
    return blocks_.back().memory;
  }

  template <class T>
  T* array(const T* values, std::size_t n) {
    static_assert(std::is_trivially_destructible<T>::value, "its bytes are overwritten");
    T* copy = static_cast<T*>(bytes(n * sizeof(T)));
    std::uninitialized_copy(values, values + n, copy);
    return copy;
  }
  template <class T>
  dynfilter::Span<const T> array(dynfilter::Span<const T> values) {
    if (values.empty()) return values;
    return {array(values.data(), values.size()), values.size()};
  }
  const char* text(const std::string& text) { return array(text.c_str(), text.size() + 1); }

  cv::Mat image(const cv::Mat& image) {
    if (image.empty()) return image.clone();
    if (host_ == Host::Reuses) {
      counted_.push_back(image.clone());
      return counted_.back();
    }
    constexpr std::size_t kPadding = 5;  // pixels
    const std::size_t row = static_cast<std::size_t>(image.cols) * image.elemSize();
    const std::size_t step = row + kPadding * image.elemSize();
    cv::Mat lent(image.rows, image.cols, image.type(),
                 bytes(step * static_cast<std::size_t>(image.rows - 1) + row), step);
    image.copyTo(lent);
    return lent;
  }
  /// A cv::Mat with counted references that the host gives away: it keeps its pixels.
  cv::Mat handed_over(const cv::Mat& image) {
    return host_ == Host::Reuses ? image.clone() : this->image(image);
  }

  dynfilter::Span<const dynfilter::Detection> detections(dynfilter::Span<const dynfilter::Detection> given) {
    std::vector<dynfilter::Detection>& lent =
        *boxes_.emplace_back(std::make_unique<std::vector<dynfilter::Detection>>(given.begin(), given.end()));
    for (dynfilter::Detection& box : lent) box.mask = image(box.mask);
    return lent;
  }

  /// Returns how many images somebody else still refers to. That is allowed to nobody.
  std::size_t take_back() {
    for (auto& list : boxes_)
      for (dynfilter::Detection& box : *list) {
        std::fill(box.class_name.begin(), box.class_name.end(), '?');
        box = dynfilter::Detection();
        std::memset(static_cast<void*>(&box.box), garbage_, sizeof box.box);
      }
    std::size_t retained = 0;
    for (cv::Mat& image : counted_) {
      retained += dynfilter::has_sole_owner(image) ? 0U : 1U;
      std::memset(image.data, garbage_, image.total() * image.elemSize());
    }
    for (const Block& block : blocks_) std::memset(block.memory, garbage_, block.size);
    if (host_ == Host::Frees) {
      boxes_.clear();
      free_blocks();
    }
    return retained;
  }

 private:
  struct Block {
    void* memory;
    std::size_t size;
  };
  void free_blocks() {
    for (const Block& block : blocks_) std::free(block.memory);
    blocks_.clear();
  }

  Host host_;
  std::uint8_t garbage_;
  std::vector<Block> blocks_;
  std::vector<cv::Mat> counted_;
  std::vector<std::unique_ptr<std::vector<dynfilter::Detection>>> boxes_;
};

/// A frame in such memory.
class LentFrame {
 public:
  LentFrame(const dynfilter::FrameView& from, Host host, std::uint8_t garbage)
      : memory_(host, garbage), view_(from) {
    view_.keypoints = memory_.array(from.keypoints);
    view_.keypoints_undistorted = memory_.array(from.keypoints_undistorted);
    view_.descriptors = memory_.image(from.descriptors);
    view_.depth_m = memory_.array(from.depth_m);
    view_.right_u_px = memory_.array(from.right_u_px);
    view_.grey = memory_.image(from.grey);
    view_.right_grey = memory_.image(from.right_grey);
    view_.depth = from.depth_handed_over ? memory_.handed_over(from.depth) : memory_.image(from.depth);
    view_.map_point_ids = memory_.array(from.map_point_ids);
    view_.map_points_world_m = memory_.array(from.map_points_world_m);
    lend_keyframes(from.covisible_keyframes);
    if (view_.matches) view_.matches->reference_index = memory_.array(from.matches->reference_index);
    if (view_.detections) view_.detections->detections = memory_.detections(from.detections->detections);
    if (view_.mask) view_.mask->labels = memory_.image(from.mask->labels);
  }

  const dynfilter::FrameView& view() const { return view_; }
  /// See LentMemory.
  std::size_t take_back() {
    view_ = dynfilter::FrameView();
    return memory_.take_back();
  }

 private:
  void lend_keyframes(dynfilter::Span<const dynfilter::KeyframeView> given) {
    std::vector<dynfilter::KeyframeView> lent(given.begin(), given.end());
    for (dynfilter::KeyframeView& keyframe : lent) {
      keyframe.keypoints_undistorted = memory_.array(keyframe.keypoints_undistorted);
      keyframe.depth_m = memory_.array(keyframe.depth_m);
      keyframe.map_point_ids = memory_.array(keyframe.map_point_ids);
    }
    view_.covisible_keyframes = memory_.array(dynfilter::Span<const dynfilter::KeyframeView>(lent));
  }

  LentMemory memory_;
  dynfilter::FrameView view_;
};

}  // namespace fuzz
