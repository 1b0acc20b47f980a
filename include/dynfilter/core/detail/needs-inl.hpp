// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/needs.hpp>

#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE Input inputs_of(const FrameView& frame) {
  Input inputs = Input::None;
  const auto add = [&](bool there, Input input) {
    if (there) inputs = inputs | input;
  };
  add(!frame.grey.empty(), Input::GreyImage);
  add(!frame.depth_m.empty() || !frame.depth.empty() || is_stereo(frame), Input::Depth);
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

DYNFILTER_INLINE void append_names(std::string& text, Input inputs) {
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
  bool any = false;
  for (const auto& [input, name] : kNames) {
    if ((inputs & input) == Input::None) continue;
    append_text(text, any ? ", " : "", name);
    any = true;
  }
  if (!any) text += "nothing";
}

DYNFILTER_INLINE std::string to_string(Input inputs) {
  std::string text;
  append_names(text, inputs);
  return text;
}

}  // namespace dynfilter
