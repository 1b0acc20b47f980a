// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/decoded_image.hpp>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter::io {

/// Throws if an image of this size is not expected.
using CheckSize = std::function<void(cv::Size)>;

/// Reads a PNG, JPEG, BMP (uncompressed, 8, 24 or 32 bits) or binary PGM or PPM image.
/// The content of the file says which it is.
/// Its size is read first by the decoder itself, and limited before memory is taken for pixels.
/// Memory: the file's bytes, and what decoded_image.hpp says for each pixel.
/// Throws IoError with the file name if it is missing, truncated, damaged, too large or not an image.
/// A warning of a decoder is an error, too. `check` is called before pixels are decoded; it may throw.
cv::Mat read_image(const std::filesystem::path& path, ImageAs as, const CheckSize& check = {});

/// The same for an image of labels. Throws IoError if it is not of 8 bits and one channel.
cv::Mat read_label_image(const std::filesystem::path& path);

namespace detail {

/// Throws IoError if the file cannot be read or has more than limits::kMaxImageBytes.
Bytes read_bytes(const std::filesystem::path& path);

/// The same as read_image, of bytes. Throws ImageFault and what `check` throws.
cv::Mat decode_image(const Bytes& bytes, ImageAs as, const CheckSize& check = {});

}  // namespace detail

}  // namespace dynfilter::io
