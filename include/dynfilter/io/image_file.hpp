// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace dynfilter::io {

namespace detail {

/// CRC-32 of PNG (ISO 3309), eight bytes at a time.
std::uint32_t crc32(const unsigned char* data, std::size_t size);

std::vector<unsigned char> read_bytes(const std::filesystem::path& path);

}  // namespace detail

/// Reads an image with cv::imdecode (`flags`: cv::ImreadModes).
/// Throws IoError with the file name if it is missing, truncated, damaged or not an image.
cv::Mat read_image(const std::filesystem::path& path, int flags);

}  // namespace dynfilter::io

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/image_file-inl.hpp>
#endif
