// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <opencv2/core/mat.hpp>

namespace dynfilter {

/// A colour copy of a grey or colour image with a ring per feature. Green is kept, red rejected, yellow
/// rejected but restored by the floor. What slides along an edge is a dash along it.
cv::Mat draw_verdict(const cv::Mat& image, Span<const cv::KeyPoint> keypoints, const Verdict& verdict);

/// One line for a log: "frame 12: 1003 features, 210 rejected, 0 restored; background_motion 210; notes".
std::string summary_line(const FrameReport& report);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/detail/draw_verdict-inl.hpp>
#endif
