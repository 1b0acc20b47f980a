// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <string>

namespace dynfilter {

/// Inputs that a filter reads from a frame. Values are combined as bits.
enum class Input : std::uint32_t {
  None = 0,
  GreyImage = 1U << 0U,
  Depth = 1U << 1U,  ///< depth per feature, or a depth image to sample it from
  Camera = 1U << 2U,
  Pose = 1U << 3U,
  Detections = 1U << 4U,
  Mask = 1U << 5U,
  Descriptors = 1U << 6U,
  MapPoints = 1U << 7U,
  Keyframes = 1U << 8U,
  Correspondence = 1U << 9U,  ///< matches of the host, or a grey image for flow, or descriptors
};

constexpr Input operator|(Input a, Input b) {
  return static_cast<Input>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
constexpr Input operator&(Input a, Input b) {
  return static_cast<Input>(static_cast<std::uint32_t>(a) & static_cast<std::uint32_t>(b));
}
/// The inputs of `a` that are not in `b`.
constexpr Input without(Input a, Input b) {
  return static_cast<Input>(static_cast<std::uint32_t>(a) & ~static_cast<std::uint32_t>(b));
}

/// Inputs and history that a filter needs.
struct Needs {
  /// The stage is skipped if one of these is missing. The report notes why.
  Input required = Input::None;
  Input optional = Input::None;  ///< used where the host provides them
  /// Number of earlier frames that the pipeline keeps for this filter.
  /// State inside the filter (tracks, evidence) is not counted and may reach further back.
  int history_frames = 0;
};

/// The inputs that a frame provides.
Input inputs_of(const FrameView& frame);

/// For example "depth, camera". Used in messages and cards.
std::string to_string(Input inputs);
/// Appends the same to a text.
void append_names(std::string& text, Input inputs);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/needs-inl.hpp>
#endif
