// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace dynfilter::io {

/// Labelled point tracks of one image sequence.
/// Pixels are distorted or undistorted, depending on the data set.
struct PointTracks {
  std::string title;  ///< first word of the first comment, e.g. "KT3DMoSeg"; "" without comments
  int points = 0, frames = 0, width_px = 0, height_px = 0;
  std::vector<int> label;       ///< per point
  std::vector<cv::Point2f> px;  ///< points x frames, NaN if not visible

  const cv::Point2f& at(int point, int frame) const {
    return px[static_cast<std::size_t>(point) * static_cast<std::size_t>(frames) +
              static_cast<std::size_t>(frame)];
  }
  bool visible(int point, int frame) const;
  /// Last frame that shows the point; -1: none.
  int last_visible(int point) const;
};

/// Reads a track file. Comments contain the header `# points P frames F width W height H`.
/// Each point has one line: its label, an integer >= 0, and `x y` per frame.
/// `nan nan` means not visible. Throws IoError with file and line.
PointTracks read_point_tracks(const std::filesystem::path& path);

/// The label with the widest spread over the image.
/// The spread is the number of cells of an 8 x 8 grid that contain its points in any frame.
/// Ties prefer more points, then the smaller label.
int widest_label(const PointTracks& tracks);

}  // namespace dynfilter::io
