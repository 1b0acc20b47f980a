// SPDX-License-Identifier: MIT
#include <dynfilter/keyframe/make_selector.hpp>

std::size_t keyframes_of(const std::vector<dynfilter::FrameSummary>& frames) {
  const auto selector = dynfilter::make_keyframe_selector("vertex_cover");
  std::size_t keyframes = 0;
  for (const dynfilter::FrameSummary& frame : frames) keyframes += selector->add(frame).size();
  return keyframes + selector->flush().size();
}
