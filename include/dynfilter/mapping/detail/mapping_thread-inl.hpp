// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/mapping_thread.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/span.hpp>
#include <exception>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter::mapping {

DYNFILTER_INLINE MappingThread::~MappingThread() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
    wake_.notify_all();
  }
  worker_.join();
}

DYNFILTER_INLINE void MappingThread::remove(std::int64_t id) {
  push([id](StaticMap& map, MappingThreadStatus&) { map.remove(id); });
}

DYNFILTER_INLINE void MappingThread::move(std::int64_t id, const Pose& T_world_camera) {
  push([id, T_world_camera](StaticMap& map, MappingThreadStatus&) { map.move(id, T_world_camera); });
}

DYNFILTER_INLINE void MappingThread::finish() {
  std::unique_lock<std::mutex> lock(mutex_);
  idle_.wait(lock, [&] { return jobs_.empty() && !busy_; });
}

DYNFILTER_INLINE MapCloud MappingThread::cloud() {
  std::unique_lock<std::mutex> lock(mutex_);
  idle_.wait(lock, [&] { return jobs_.empty() && !busy_; });
  return map_.cloud();
}

DYNFILTER_INLINE MapSources MappingThread::sources() {
  std::unique_lock<std::mutex> lock(mutex_);
  idle_.wait(lock, [&] { return jobs_.empty() && !busy_; });
  return map_.sources();
}

DYNFILTER_INLINE MapState MappingThread::state() {
  std::unique_lock<std::mutex> lock(mutex_);
  idle_.wait(lock, [&] { return jobs_.empty() && !busy_; });
  return map_.state();
}

DYNFILTER_INLINE MappingThreadStatus MappingThread::status() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return status_;
}

DYNFILTER_INLINE MappingThread::OwnedFrame::OwnedFrame(const MapFrame& from)
    : frame(from),
      moving_px(from.moving_px.begin(), from.moving_px.end()),
      still_px(from.still_px.begin(), from.still_px.end()),
      detections(from.detections.begin(), from.detections.end()) {
  for (cv::Mat* image : {&frame.depth, &frame.bgr, &frame.moving_mask, &frame.classes})
    *image = image->clone();
  for (Detection& detection : detections) detection.mask = detection.mask.clone();
  frame.moving_px = moving_px;
  frame.still_px = still_px;
  frame.detections = detections;
}

DYNFILTER_INLINE bool MappingThread::submit(const MapFrame& frame, bool keyframe) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    status_.submitted += keyframe ? 1 : 0;
    if (frames_waiting_ >= capacity_) {
      ++(keyframe ? status_.dropped : status_.dropped_neighbours);
      return false;
    }
    ++frames_waiting_;
  }
  const auto owned = std::make_shared<OwnedFrame>(frame);
  push([this, owned, keyframe](StaticMap& map, MappingThreadStatus& done) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      --frames_waiting_;
    }
    if (!keyframe) {
      map.observe(owned->frame);
      return;
    }
    const MapReport report = map.add(owned->frame);
    ++(report.used ? done.fused : done.skipped);
    if (!report.used) done.last_note = report.note;
    done.pixels = report.pixels;
    done.left_pixels = report.pixels - report.cut_pixels - report.edge_pixels;
    done.fused_ms = report.used ? report.time_ms : 0;
  });
  return true;
}

inline void MappingThread::push(Job job) {
  const std::lock_guard<std::mutex> lock(mutex_);
  jobs_.push_back(std::move(job));
  wake_.notify_all();
}

DYNFILTER_INLINE void MappingThread::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return stop_ || !jobs_.empty(); });
    if (stop_) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    busy_ = true;
    lock.unlock();
    MappingThreadStatus done;
    try {
      job(map_, done);
    } catch (const std::exception& error) {  // mostly out of memory; the tracker continues
      ++done.skipped;
      done.last_note = error.what();
    }
    job = nullptr;
    lock.lock();
    busy_ = false;
    status_.fused += done.fused;
    status_.skipped += done.skipped;
    status_.pixels += done.pixels;
    status_.left_pixels += done.left_pixels;
    status_.fused_ms += done.fused_ms;
    if (done.skipped > 0) status_.last_note = done.last_note;
    if (jobs_.empty()) idle_.notify_all();
  }
}

}  // namespace dynfilter::mapping
