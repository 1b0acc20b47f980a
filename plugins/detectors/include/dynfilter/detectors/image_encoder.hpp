// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace dynfilter::io {

/// Of JPEG images that are looked at, from 0 to 100.
inline constexpr int kGoodQuality = 95;

/// The bytes of a PNG image: CV_8UC1, CV_16UC1 or CV_8UC3 (BGR). Written quickly rather than small.
/// Throws IoError if the image is of another type, empty or too large for the format.
std::vector<std::uint8_t> encode_png(const cv::Mat& image);

/// The bytes of a JPEG image: CV_8UC1 or CV_8UC3 (BGR). Throws as encode_png() does.
std::vector<std::uint8_t> encode_jpeg(const cv::Mat& image, int quality = kGoodQuality);

/// PNG, or JPEG where the name ends with .jpg. Throws IoError, with the path.
void write_image(const std::filesystem::path& path, const cv::Mat& image);

}  // namespace dynfilter::io
