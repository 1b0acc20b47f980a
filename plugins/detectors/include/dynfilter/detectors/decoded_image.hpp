// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <stdexcept>
#include <vector>

namespace dynfilter::io {

/// The form in which an image is wanted.
enum class ImageAs {
  Stored,  ///< as in the file: depth, labels. 8 or 16 bits; 1, 3 (BGR) or 4 (BGRA) channels. Never turned
  Colour,  ///< CV_8UC3, BGR. Alpha is left out, and the image is turned as its Exif orientation says
};

namespace detail {

using Bytes = std::vector<unsigned char>;

/// What reading an image allocates in total, beyond the file's bytes: at most so many for each pixel ...
/// Most takes a progressive JPEG that is turned: 6 for its coefficients, and twice 3 for the image.
inline constexpr std::size_t kMaxDecodingBytesPerPixel = 12;
/// ... and these: rows and tables of the decoders, blocks at the edge of a JPEG, metadata of a PNG.
inline constexpr std::size_t kMaxDecodingBytes = std::size_t{16} * 1024 * 1024;

/// Exif's orientation of an image that is stored upright. The others are 2 to 8.
inline constexpr int kUpright = 1;

/// What an image file says before its pixels are decoded.
struct ImageHeader {
  cv::Size size;
  int orientation = kUpright;
};

/// Called between header and pixels. Throws if the image is not wanted: then no memory is taken for it.
using AcceptHeader = std::function<void(const ImageHeader&)>;

struct DecodedImage {
  cv::Mat pixels;  ///< not turned yet
  int orientation = kUpright;
};

/// Why bytes are no image: "is truncated".
class ImageFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace detail

}  // namespace dynfilter::io
