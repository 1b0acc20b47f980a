// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/verdict.hpp>
#include <memory>
#include <string>

namespace dynfilter {

struct HostLimits;  // pipeline.hpp
struct HostTracking;
struct PipelineConfig;

/// Sees what a pipeline is given and what it answers, in the thread of the call: Pipeline::set_observer().
/// It must not throw.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  /// First of all: what the pipeline was made of.
  virtual void begin(const PipelineConfig& config) = 0;
  /// Before the frame is judged. Its memory is valid until judged() returns.
  virtual void frame(const FrameView& frame, CallPoint point, const HostLimits& limits) = 0;
  virtual void judged(Verdict& verdict) = 0;  ///< the answer, whose report may get notes
  virtual void reset() = 0;                   ///< as Pipeline::reset() was called
  virtual void lost() = 0;                    ///< as Pipeline::lost() was called
  /// As Pipeline::update_pose() was called.
  virtual void pose(std::int64_t frame_id, const Pose& T_world_camera, PoseProvenance provenance,
                    const HostTracking& tracking) = 0;
};

/// What a recording may cost.
struct RecordingParams {
  int max_mb = 4096;   ///< of the file [MB]: the recording ends there
  bool images = true;  ///< false: they are left out, and pipelines that need them replay differently
  bool waits = false;  ///< if images come too fast to be written; false: they are left out
};

/// A flight recorder (docs/how-to/flight_recorder.md). Replaces the file. Throws IoError if it cannot be
/// written. The component dynfilter::recorder has it.
std::shared_ptr<FrameObserver> open_recording(const std::string& file, const RecordingParams& params = {});
#if defined(DYNFILTER_HEADER_ONLY) && !defined(DYNFILTER_HAS_RECORDER)
DYNFILTER_INLINE std::shared_ptr<FrameObserver> open_recording(const std::string& file,
                                                               const RecordingParams&) {
  throw IoError(file + ": this program has the headers only: link dynfilter::recorder");
}
#endif

}  // namespace dynfilter
