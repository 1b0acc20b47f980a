// SPDX-License-Identifier: MIT
#include "image_writer.hpp"

#include <algorithm>
#include <cstring>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <exception>

namespace dynfilter::recorder {

namespace {

/// Row by row: a host's image may be padded.
bool same_pixels(const cv::Mat& a, const cv::Mat& b) {
  if (a.size != b.size || a.type() != b.type() || a.dims > 2) return false;
  for (int row = 0; row < a.rows; ++row)
    if (std::memcmp(a.ptr(row), b.ptr(row), static_cast<std::size_t>(a.cols) * a.elemSize()) != 0)
      return false;
  return true;
}

}  // namespace

ImageWriter::~ImageWriter() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  wakes_.notify_one();
  thread_.join();
}

bool ImageWriter::begin(std::uint64_t call, std::size_t image_bytes) {
  next_ = Job();
  next_.call = call;
  std::unique_lock<std::mutex> lock(mutex_);
  const auto fits = [&] { return waiting_bytes_ == 0 || waiting_bytes_ + image_bytes <= kMaxWaitingBytes; };
  if (waits_) written_.wait(lock, fits);
  if (fits()) return true;
  slots_.clear();
  return false;
}

ImagePlace ImageWriter::place(std::uint32_t number, const cv::Mat& image) {
  Slot& slot = slots_[number];
  if (slot.call == 0 || !same_pixels(image, slot.image)) {
    slot.call = next_.call;
    slot.image = copy_of(image, slot);
    next_.images.emplace_back(number, slot.image);
    next_.bytes += image.total() * image.elemSize();
  }
  return {ImagePlace::Kind::Stored, slot.call};
}

void ImageWriter::end() {
  if (next_.images.empty()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_bytes_ += next_.bytes;
    jobs_.push_back(std::move(next_));
  }
  wakes_.notify_one();
}

/// In memory that is there already, if there is any: fresh pages cost more than the copy.
cv::Mat ImageWriter::copy_of(const cv::Mat& image, Slot& slot) {
  cv::Mat copy;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    slot.image.release();
    const auto free = std::find_if(slot.buffers.begin(), slot.buffers.end(), has_sole_owner);
    if (free != slot.buffers.end()) {
      copy = *free;
      slot.buffers.erase(free);
    }
  }
  image.copyTo(copy);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (slot.buffers.size() == kBuffers) slot.buffers.erase(slot.buffers.begin());
  slot.buffers.push_back(copy);
  return copy;
}

void ImageWriter::work() {
  for (;;) {
    Job job;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      wakes_.wait(lock, [&] { return ends_ || !jobs_.empty(); });
      if (jobs_.empty()) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    try {
      write(job);
    } catch (const std::exception&) {  // no memory: the record is missing, which the reader says
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_bytes_ -= job.bytes;
    job.images.clear();
    written_.notify_one();
  }
}

void ImageWriter::write(const Job& job) {
  ByteWriter bytes(buffer_.raw);
  bytes.count(job.images, 1);
  for (const auto& [slot, image] : job.images) bytes.number(slot), bytes.matrix(image);
  file_.append(RecordKind::Images, job.call, buffer_);
}

}  // namespace dynfilter::recorder
