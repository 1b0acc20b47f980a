// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "frame_record.hpp"
#include "record_file.hpp"

namespace dynfilter::recorder {

/// Compresses and writes images in a thread of its own, so that the tracker only pays for copies of them.
class ImageWriter {
 public:
  /// `waits`: begin() waits until there is room.
  ImageWriter(RecordFile& file, bool waits) : file_(file), waits_(waits), thread_([this] { work(); }) {}
  ImageWriter(const ImageWriter&) = delete;
  ImageWriter& operator=(const ImageWriter&) = delete;
  /// Writes what waits.
  ~ImageWriter();

  /// Begins a frame. False: too many images wait, and none of this frame is taken.
  bool begin(std::uint64_t call, std::size_t image_bytes);
  /// A copy of the image to be written, or where the same pixels are already.
  ImagePlace place(std::uint32_t slot, const cv::Mat& image);
  /// Hands the copies over.
  void end();

 private:
  /// Images that wait, at most: two seconds of 640x480 with depth.
  static constexpr std::size_t kMaxWaitingBytes = std::size_t{64} * 1024 * 1024;

  using Images = std::vector<std::pair<std::uint32_t, cv::Mat>>;
  struct Job {
    std::uint64_t call = 0;
    Images images;
    std::size_t bytes = 0;
  };
  /// What a slot got last, and memory for it. Memory that a job still needs has two owners.
  struct Slot {
    std::uint64_t call = 0;
    cv::Mat image;
    std::vector<cv::Mat> buffers;
  };
  static constexpr std::size_t kBuffers = 3;  ///< of a slot: one is kept, one is written, one is filled

  cv::Mat copy_of(const cv::Mat& image, Slot& slot);
  void work();
  void write(const Job& job);

  RecordFile& file_;
  bool waits_;
  Job next_;
  std::map<std::uint32_t, Slot> slots_;

  std::mutex mutex_;  ///< of the members below, and of the images' counts of owners
  std::condition_variable wakes_, written_;
  std::deque<Job> jobs_;
  std::size_t waiting_bytes_ = 0;
  bool ends_ = false;
  RecordBuffer buffer_;
  std::thread thread_;  ///< last: it uses the others
};

}  // namespace dynfilter::recorder
