// SPDX-License-Identifier: MIT
#include "bmp_image.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

namespace dynfilter::io::detail {

/// The headers of a BMP file: BITMAPFILEHEADER and BITMAPINFOHEADER, or one of its extensions.
class BmpHeader {
 public:
  explicit BmpHeader(const Bytes& bytes) : bytes_(bytes) {
    if (bytes.size() < kHeaderBytes) throw ImageFault("is truncated");
    const std::uint32_t info_bytes = number(14), compression = number(30);
    height_ = static_cast<std::int32_t>(number(22));
    bits = static_cast<int>(number(28) & 0xFFFFU);
    if (info_bytes < kHeaderBytes - kFileHeaderBytes || compression != 0 ||
        (bits != 8 && bits != 24 && bits != 32))
      throw ImageFault("is not an uncompressed BMP image of 8, 24 or 32 bits for each pixel");
    const auto width = static_cast<std::int32_t>(number(18));
    if (width < 1 || height_ == 0 || height_ == INT32_MIN) throw ImageFault("is damaged (width or height)");
    size = cv::Size(width, height_ < 0 ? -height_ : height_);
    if (bits == 8) read_palette(std::size_t{kFileHeaderBytes} + info_bytes);
  }

  /// Rows are stored from the bottom, or from the top if the height is negative, in multiples of 4 bytes.
  /// Throws ImageFault if the file is shorter. The size must be within the limits.
  void require_rows() const {
    const std::int64_t end = number(10) + stride() * size.height;
    if (end > static_cast<std::int64_t>(bytes_.size())) throw ImageFault("is truncated");
  }
  const unsigned char* row(int y) const {
    return bytes_.data() + number(10) + stride() * (height_ < 0 ? y : size.height - 1 - y);
  }

  cv::Size size;
  int bits = 0;
  std::array<unsigned char, 256 * 4> palette{};  ///< blue, green, red, 0
  bool grey = false;                             ///< the palette has no colours

 private:
  static constexpr std::size_t kFileHeaderBytes = 14, kHeaderBytes = 54;

  std::int64_t stride() const { return (std::int64_t{size.width} * bits + 31) / 32 * 4; }

  std::uint32_t number(std::size_t at) const {
    return bytes_[at] | (std::uint32_t{bytes_[at + 1]} << 8) | (std::uint32_t{bytes_[at + 2]} << 16) |
           (std::uint32_t{bytes_[at + 3]} << 24);
  }

  void read_palette(std::size_t at) {
    const std::uint32_t used = number(46);
    if (used > palette.size() / 4) throw ImageFault("is damaged (size of the palette)");
    const std::size_t n = used == 0 ? palette.size() : 4 * std::size_t{used};
    if (at > bytes_.size() || n > bytes_.size() - at) throw ImageFault("is truncated");
    std::memcpy(palette.data(), bytes_.data() + at, n);
    grey = true;
    for (std::size_t k = 0; k < palette.size(); k += 4)
      grey = grey && palette[k] == palette[k + 1] && palette[k] == palette[k + 2];
  }

  const Bytes& bytes_;
  std::int32_t height_ = 0;
};

DecodedImage decode_bmp(const Bytes& bytes, ImageAs as, const AcceptHeader& accept) {
  const BmpHeader header(bytes);
  accept({header.size, kUpright});
  header.require_rows();
  DecodedImage image;
  const int channels = as == ImageAs::Stored && header.grey ? 1 : 3;
  image.pixels.create(header.size, CV_8UC(channels));
  for (int y = 0; y < image.pixels.rows; ++y) {
    const unsigned char* from = header.row(y);
    unsigned char* to = image.pixels.ptr(y);
    for (int x = 0; x < image.pixels.cols; ++x, from += header.bits / 8, to += channels) {
      const unsigned char* bgr = header.bits == 8 ? &header.palette[4 * std::size_t{*from}] : from;
      for (int c = 0; c < channels; ++c) to[c] = bgr[c];
    }
  }
  return image;
}

}  // namespace dynfilter::io::detail
