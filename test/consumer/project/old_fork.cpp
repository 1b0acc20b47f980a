// SPDX-License-Identifier: MIT
#include <cstdio>
#include <dynfilter/facade/facade.hpp>

int main() {
  dynfilter::facade::DynFilter filter;
  dynfilter::facade::Frame frame;
  dynfilter::facade::Verdicts verdicts;
  frame.keypoints.push_back(cv::KeyPoint(10, 10, 31));
  const bool right = dynfilter::facade::abi_version() == dynfilter::facade::kAbiVersion &&
                     filter.load_text("pipeline: { before_pose: [ background_motion ] }") &&
                     filter.process(frame, dynfilter::facade::CallPoint::BeforePose, verdicts) &&
                     verdicts.keep.size() == 1 && verdicts.keep[0] == 1;
  std::printf("C++11: %s %s\n", right ? "works" : "is broken", filter.error().c_str());
  return right ? 0 : 1;
}
