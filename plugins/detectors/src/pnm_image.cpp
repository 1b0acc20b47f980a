// SPDX-License-Identifier: MIT
#include "pnm_image.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace dynfilter::io::detail {

/// Samples of 8 or 16 bits, row by row, as PGM and PPM have them.
struct PnmSamples {
  const unsigned char* begin = nullptr;
  int channels = 1;
  bool wide = false;

  template <class Value>
  Value at(std::size_t i) const {
    constexpr int kBitsLost = sizeof(Value) == 1 ? 8 : 0;
    if (!wide) return begin[i];
    return static_cast<Value>(((begin[2 * i] << 8) | begin[2 * i + 1]) >> kBitsLost);
  }
};

template <class Value>
void copy_samples(const PnmSamples& from, cv::Mat& to) {
  std::size_t first = 0;
  for (int y = 0; y < to.rows; ++y) {
    Value* value = to.ptr<Value>(y);
    for (int x = 0; x < to.cols; ++x, first += static_cast<std::size_t>(from.channels))
      for (int c = 0; c < to.channels(); ++c)  // RGB becomes BGR, grey is repeated
        *value++ = from.at<Value>(first + static_cast<std::size_t>(from.channels == 3 ? 2 - c : 0));
  }
}

/// A number of the header, after blanks and comments.
inline std::optional<int> pnm_number(const Bytes& bytes, std::size_t& at) {
  constexpr int kMaxDigits = 9;
  const auto byte = [&] { return at < bytes.size() ? bytes[at] : 0; };
  const auto blank = [](int c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  for (; blank(byte()) || byte() == '#'; ++at)
    if (byte() == '#')
      while (at < bytes.size() && byte() != '\n' && byte() != '\r') ++at;
  int number = 0, digits = 0;
  for (; byte() >= '0' && byte() <= '9' && digits < kMaxDigits; ++at, ++digits)
    number = 10 * number + (byte() - '0');
  if (digits == 0 || !blank(byte())) return std::nullopt;
  return number;
}

DecodedImage decode_pnm(const Bytes& bytes, ImageAs as, const AcceptHeader& accept) {
  constexpr int kMaxValue = 65535, kMaxNarrow = 255;
  std::size_t at = 2;
  const std::optional<int> width = pnm_number(bytes, at), height = pnm_number(bytes, at),
                           most = pnm_number(bytes, at);
  if (!width || !height || !most || *width < 1 || *height < 1 || *most < 1 || *most > kMaxValue)
    throw ImageFault("is damaged (header: expected width, height and the largest value, 1 to 65535)");
  ++at;  // the blank after the last number
  accept({cv::Size(*width, *height), kUpright});
  PnmSamples samples;
  samples.channels = bytes[1] == '6' ? 3 : 1;
  samples.wide = *most > kMaxNarrow;
  const std::int64_t expected =
      std::int64_t{*width} * *height * samples.channels * (samples.wide ? 2 : 1);  // within the limits
  if (static_cast<std::int64_t>(bytes.size() - at) < expected) throw ImageFault("is truncated");
  samples.begin = bytes.data() + at;
  DecodedImage image;
  const bool wide = as == ImageAs::Stored && samples.wide;
  image.pixels.create(*height, *width,
                      CV_MAKETYPE(wide ? CV_16U : CV_8U, as == ImageAs::Colour ? 3 : samples.channels));
  wide ? copy_samples<std::uint16_t>(samples, image.pixels)
       : copy_samples<std::uint8_t>(samples, image.pixels);
  return image;
}

}  // namespace dynfilter::io::detail
