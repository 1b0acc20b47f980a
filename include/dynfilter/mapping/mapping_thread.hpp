// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/static_map.hpp>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace dynfilter::mapping {

/// Counters of a mapping thread.
struct MappingThreadStatus {
  std::size_t submitted = 0, fused = 0, skipped = 0;  ///< keyframes; skipped: unusable for the map
  /// Keyframes dropped because the queue was full.
  std::size_t dropped = 0;
  /// Other frames dropped because the queue was full.
  std::size_t dropped_neighbours = 0;
  std::string last_note;  ///< of the last skipped keyframe
  /// Pixels with usable depth in fused keyframes.
  std::size_t pixels = 0;
  /// Of these: neither removed as moving nor at a depth jump.
  std::size_t left_pixels = 0;
  double fused_ms = 0;  ///< total time of fusion
};

/// A StaticMap in its own thread. The tracker only copies the images and never waits. The queue holds
/// `capacity` frames. A frame that finds it full is dropped and counted. Removals and moves are never
/// dropped. Without drops, the map is bit for bit that of the same calls on a StaticMap. The destructor
/// completes the current frame and drops the others. Call finish() first to process all of them.
class MappingThread {
 public:
  /// Throws ConfigError if a parameter is out of range.
  explicit MappingThread(const MappingParams& params = MappingParams(), std::size_t capacity = 16)
      : map_(params), capacity_(capacity), worker_([this] { work(); }) {}
  ~MappingThread();
  MappingThread(const MappingThread&) = delete;
  MappingThread& operator=(const MappingThread&) = delete;

  /// Both copy what they keep. False: dropped.
  bool add(const MapFrame& keyframe) { return submit(keyframe, true); }
  /// Queues any other frame; false: the queue was full.
  bool observe(const MapFrame& frame) { return submit(frame, false); }
  /// Queues a removal.
  void remove(std::int64_t id) {
    push([id](StaticMap& map, MappingThreadStatus&) { map.remove(id); });
  }
  /// Queues a move to this pose.
  void move(std::int64_t id, const Pose& T_world_camera) {
    push([id, T_world_camera](StaticMap& map, MappingThreadStatus&) { map.move(id, T_world_camera); });
  }

  /// Waits until everything submitted is processed.
  void finish() { when_idle(); }
  /// The map after everything submitted. Waits for it, as the next two do.
  MapCloud cloud() {
    const auto lock = when_idle();
    return map_.cloud();
  }
  /// See StaticMap::sources().
  MapSources sources() {
    const auto lock = when_idle();
    return map_.sources();
  }
  /// See StaticMap::state().
  MapState state() {
    const auto lock = when_idle();
    return map_.state();
  }
  /// Counters, without waiting.
  MappingThreadStatus status() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return status_;
  }

 private:
  using Job = std::function<void(StaticMap&, MappingThreadStatus&)>;

  /// A frame with deep copies of its data.
  struct OwnedFrame {
    MapFrame frame;
    std::vector<cv::Point2f> moving_px, still_px;
    std::vector<Detection> detections;

    explicit OwnedFrame(const MapFrame& from);  ///< copies the images
  };

  bool submit(const MapFrame& frame, bool keyframe);
  void push(Job job) {
    const std::lock_guard<std::mutex> lock(mutex_);
    jobs_.push_back(std::move(job));
    wake_.notify_all();
  }
  void work();
  std::unique_lock<std::mutex> when_idle() {
    std::unique_lock<std::mutex> lock(mutex_);
    idle_.wait(lock, [&] { return jobs_.empty() && !busy_; });
    return lock;
  }

  StaticMap map_;  ///< used by the worker while busy_
  std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable wake_, idle_;
  std::deque<Job> jobs_;
  std::size_t frames_waiting_ = 0;
  bool stop_ = false, busy_ = false;
  MappingThreadStatus status_;
  std::thread worker_;  ///< last member, because it uses all others
};

inline MappingThread::~MappingThread() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
    wake_.notify_all();
  }
  worker_.join();
}

inline MappingThread::OwnedFrame::OwnedFrame(const MapFrame& from)
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

inline bool MappingThread::submit(const MapFrame& frame, bool keyframe) {
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

inline void MappingThread::work() {
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
