// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/draw_verdict.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter {

DYNFILTER_INLINE cv::Mat draw_verdict(const cv::Mat& image, Span<const cv::KeyPoint> keypoints,
                                      const Verdict& verdict) {
  cv::Mat out;
  if (image.empty() || image.depth() != CV_8U) return out;
  if (image.channels() == 1)
    cv::cvtColor(image, out, cv::COLOR_GRAY2BGR);
  else if (image.channels() == 4)
    cv::cvtColor(image, out, cv::COLOR_BGRA2BGR);
  else
    image.copyTo(out);
  const std::size_t n = std::min(keypoints.size(), verdict.size());
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2f& at = keypoints[i].pt;
    if (!std::isfinite(at.x) || !std::isfinite(at.y)) continue;
    const cv::Scalar colour = !verdict.keep(i)           ? cv::Scalar(0, 0, 255)
                              : verdict.restored[i] != 0 ? cv::Scalar(0, 220, 255)
                                                         : cv::Scalar(0, 200, 0);
    if (verdict.keep(i) && i < verdict.spread.size() && verdict.spread[i].along >= MatchSpread::kFar)
      cv::line(out, at - 4 * verdict.spread[i].edge, at + 4 * verdict.spread[i].edge, colour, 1, cv::LINE_AA);
    else
      cv::circle(out, at, verdict.keep(i) ? 2 : 3, colour, 1, cv::LINE_AA);
  }
  return out;
}

DYNFILTER_INLINE std::string summary_line(const FrameReport& report) {
  std::string line = "frame " + std::to_string(report.frame_id) + ": " + std::to_string(report.features) +
                     " features, " + std::to_string(report.rejected) + " rejected, " +
                     std::to_string(report.restored) + " restored";
  for (const StageReport& stage : report.stages) {
    line += "; " + stage.name + " ";
    line += stage.skipped ? "skipped" : stage.failed ? "failed" : std::to_string(stage.dynamic);
    if (!stage.note.empty()) line += " (" + stage.note + ")";
  }
  for (const std::string& note : report.notes) line += "; " + note;
  return line;
}

}  // namespace dynfilter
