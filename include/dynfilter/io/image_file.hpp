// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

namespace dynfilter::io {

namespace detail {

/// CRC-32 of PNG (ISO 3309), eight bytes at a time.
std::uint32_t crc32(const unsigned char* data, std::size_t size);

/// Throws IoError if the file cannot be read or has more than limits::kMaxImageBytes.
std::vector<unsigned char> read_bytes(const std::filesystem::path& path);

/// Width and height as the header of a PNG, JPEG, BMP or PNM file says. Nothing is decoded.
/// Nothing if the bytes have no such header, or the size is not positive.
std::optional<cv::Size> image_size(const std::vector<unsigned char>& bytes);

}  // namespace detail

/// Throws if an image of this size is not expected.
using CheckSize = std::function<void(cv::Size)>;

/// Reads a PNG, JPEG, BMP or PNM image with cv::imdecode (`flags`: cv::ImreadModes).
/// Its size is checked before it is decoded, since a small file may decode to gigabytes.
/// Throws IoError with the file name if it is missing, truncated, damaged, too large or not an image,
/// and what `check` throws.
cv::Mat read_image(const std::filesystem::path& path, int flags, const CheckSize& check = {});

}  // namespace dynfilter::io

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/image_file-inl.hpp>
#endif
