// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/static_map.hpp>
#include <functional>
#include <mutex>
#include <opencv2/core/types.hpp>
#include <string>
#include <thread>
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

/// A StaticMap in its own thread. The tracker only copies the images and never waits.
/// The queue holds `capacity` frames. A frame that finds it full is dropped and counted.
/// Removals and moves are never dropped.
/// Without drops, the map is bit for bit that of the same calls on a StaticMap.
/// The destructor completes the current frame and drops the others.
/// Call finish() first to process all of them.
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
  bool observe(const MapFrame& frame) { return submit(frame, false); }
  void remove(std::int64_t id);
  void move(std::int64_t id, const Pose& T_world_camera);

  /// Waits until everything submitted is processed.
  void finish();
  /// The map after everything submitted. Waits for it.
  MapCloud cloud();
  MapSources sources();
  MapState state();
  MappingThreadStatus status();

 private:
  using Job = std::function<void(StaticMap&, MappingThreadStatus&)>;

  /// A frame with deep copies of its data.
  struct OwnedFrame {
    MapFrame frame;
    std::vector<cv::Point2f> moving_px, still_px;
    std::vector<Detection> detections;

    explicit OwnedFrame(const MapFrame& from);
  };

  bool submit(const MapFrame& frame, bool keyframe);
  void push(Job job);

  void work();

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

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/mapping_thread-inl.hpp>
#endif
