// SPDX-License-Identifier: MIT
// A stand-in of libORB_SLAM2.so, which check_library.cmake examines.
#include "hosts/library/tracking.hpp"

#include <dynfilter/hosts/orb_slam.hpp>
#include <opencv2/core.hpp>

#include "hosts/host_stand_ins.hpp"

namespace ORB_SLAM2 {

Tracking::Tracking(const std::string& settings_file)
    : mpDynFilter(std::make_shared<dynfilter::OrbSlam>(settings_file, 2)) {}

std::string Tracking::grab(unsigned number) {
  host::v2::Frame frame;
  frame.mnId = number;
  frame.mTimeStamp = 0.04 * number;
  frame.mK = (cv::Mat_<float>(3, 3) << 250, 0, 160, 0, 250, 120, 0, 0, 1);
  cv::Mat grey(240, 320, CV_8UC1);
  cv::theRNG().state = number;
  cv::randu(grey, 0, 256);
  for (int i = 0; i < 300; ++i) {
    frame.mvKeys.emplace_back(static_cast<float>(10 + 15 * (i % 20)), static_cast<float>(8 + 15 * (i / 20)),
                              31.F);
    frame.mvDepth.push_back(2), frame.mvuRight.push_back(-1);
    frame.mvpMapPoints.push_back(nullptr), frame.mvbOutlier.push_back(false);
  }
  frame.mvKeysUn = frame.mvKeys;
  frame.mDescriptors = cv::Mat::zeros(300, 32, CV_8U);
  frame.N = 300;
  mpDynFilter->before_tracking(frame, grey, cv::Mat(grey.size(), CV_32FC1, cv::Scalar(2)), true);
  return mpDynFilter->summary();
}

int Tracking::stages_of(const dynfilter::OrbSlam& filter) {
  return static_cast<int>(filter.verdict().report.stages.size());
}

}  // namespace ORB_SLAM2
