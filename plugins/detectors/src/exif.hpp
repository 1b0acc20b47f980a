// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter::io::detail {

/// The orientation (1 to 8) in Exif data, which begin with the header of TIFF. 1 if there is none.
/// Source: CIPA DC-008 (Exif 2.3), tag 0x0112 of IFD 0.
int exif_orientation(const unsigned char* data, std::size_t size) noexcept;

/// Orientations 5 to 8 exchange width and height.
cv::Size turned(const cv::Size& size, int orientation);
void turn(cv::Mat& image, int orientation);

}  // namespace dynfilter::io::detail
