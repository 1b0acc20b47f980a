// SPDX-License-Identifier: MIT
#include "exif.hpp"

#include <cstdint>
#include <dynfilter/detectors/decoded_image.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::io::detail {

/// Integers of TIFF, in the order of bytes that its header names.
class TiffBytes {
 public:
  TiffBytes(const unsigned char* data, std::size_t size) : data_(data), size_(size) {
    little_ = size >= 2 && data[0] == 'I' && data[1] == 'I';
  }
  /// 0 beyond the end.
  std::uint32_t integer(std::size_t at, std::size_t bytes) const {
    if (at > size_ || bytes > size_ - at) return 0;
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < bytes; ++k) value = (value << 8) | data_[at + (little_ ? bytes - 1 - k : k)];
    return value;
  }

 private:
  const unsigned char* data_;
  std::size_t size_;
  bool little_;
};

int exif_orientation(const unsigned char* data, std::size_t size) noexcept {
  constexpr std::uint32_t kTiff = 42, kOrientation = 0x0112, kLast = 8;
  constexpr std::size_t kEntryBytes = 12;
  const TiffBytes tiff(data, size);
  if (tiff.integer(2, 2) != kTiff) return kUpright;
  const std::size_t directory = tiff.integer(4, 4);
  const std::uint32_t entries = tiff.integer(directory, 2);
  for (std::uint32_t k = 0; k < entries; ++k) {
    const std::size_t entry = directory + 2 + k * kEntryBytes;
    if (entry >= size) break;
    if (tiff.integer(entry, 2) != kOrientation) continue;
    const std::uint32_t orientation = tiff.integer(entry + 8, 2);
    return orientation >= 1 && orientation <= kLast ? static_cast<int>(orientation) : kUpright;
  }
  return kUpright;
}

cv::Size turned(const cv::Size& size, int orientation) {
  return orientation >= 5 ? cv::Size(size.height, size.width) : size;
}

void turn(cv::Mat& image, int orientation) {
  constexpr int kRows = 0, kColumns = 1, kBoth = -1;  // what cv::flip reverses
  if (orientation >= 5) cv::transpose(image, image);
  if (orientation == 2 || orientation == 6) cv::flip(image, image, kColumns);
  if (orientation == 3 || orientation == 7) cv::flip(image, image, kBoth);
  if (orientation == 4 || orientation == 8) cv::flip(image, image, kRows);
}

}  // namespace dynfilter::io::detail
