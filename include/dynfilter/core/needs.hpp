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
inline Input inputs_of(const FrameView& frame) {
  Input inputs = Input::None;
  const auto add = [&](bool there, Input input) {
    if (there) inputs = inputs | input;
  };
  add(!frame.grey.empty(), Input::GreyImage);
  add(!frame.depth_m.empty() || !frame.depth.empty(), Input::Depth);
  add(frame.camera.has_value() && frame.camera->valid(), Input::Camera);
  add(frame.pose_provenance != PoseProvenance::None, Input::Pose);
  add(frame.detections.has_value(), Input::Detections);
  add(frame.mask.has_value(), Input::Mask);
  add(!frame.descriptors.empty(), Input::Descriptors);
  add(!frame.map_point_ids.empty(), Input::MapPoints);
  add(!frame.covisible_keyframes.empty(), Input::Keyframes);
  add(frame.matches.has_value() || !frame.grey.empty() || !frame.descriptors.empty(), Input::Correspondence);
  return inputs;
}

/// For example "depth, camera". Used in messages and cards.
inline std::string to_string(Input inputs) {
  static constexpr std::pair<Input, const char*> kNames[] = {{Input::GreyImage, "grey image"},
                                                             {Input::Depth, "depth"},
                                                             {Input::Camera, "camera"},
                                                             {Input::Pose, "pose"},
                                                             {Input::Detections, "boxes"},
                                                             {Input::Mask, "mask"},
                                                             {Input::Descriptors, "descriptors"},
                                                             {Input::MapPoints, "map points"},
                                                             {Input::Keyframes, "covisible keyframes"},
                                                             {Input::Correspondence, "correspondences"}};
  std::string text;
  for (const auto& [input, name] : kNames) {
    if ((inputs & input) == Input::None) continue;
    if (!text.empty()) text += ", ";
    text += name;
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace dynfilter
