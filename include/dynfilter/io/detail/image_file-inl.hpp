// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/image_file.hpp>

#include <array>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/limits.hpp>
#include <fstream>
#include <ios>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>

namespace dynfilter::io {

namespace detail {

using Crc32Tables = std::array<std::array<std::uint32_t, 256>, 8>;

inline const Crc32Tables& crc32_tables() {
  static const Crc32Tables tables = [] {
    Crc32Tables t{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = (c & 1U) ? 0xEDB88320U ^ (c >> 1) : c >> 1;
      t[0][i] = c;
    }
    for (std::size_t k = 1; k < 8; ++k) {
      for (std::size_t i = 0; i < 256; ++i) t[k][i] = t[0][t[k - 1][i] & 0xFFU] ^ (t[k - 1][i] >> 8);
    }
    return t;
  }();
  return tables;
}

inline std::uint32_t little_endian32(const unsigned char* p) {
  return p[0] | (std::uint32_t{p[1]} << 8) | (std::uint32_t{p[2]} << 16) | (std::uint32_t{p[3]} << 24);
}

inline std::uint32_t big_endian32(const unsigned char* p) {
  return p[3] | (std::uint32_t{p[2]} << 8) | (std::uint32_t{p[1]} << 16) | (std::uint32_t{p[0]} << 24);
}

DYNFILTER_INLINE std::uint32_t crc32(const unsigned char* data, std::size_t size) {
  const Crc32Tables& t = crc32_tables();
  std::uint32_t c = 0xFFFFFFFFU;
  for (; size >= 8; size -= 8, data += 8) {
    const std::uint32_t a = c ^ little_endian32(data), b = little_endian32(data + 4);
    c = t[7][a & 0xFFU] ^ t[6][(a >> 8) & 0xFFU] ^ t[5][(a >> 16) & 0xFFU] ^ t[4][a >> 24] ^ t[3][b & 0xFFU] ^
        t[2][(b >> 8) & 0xFFU] ^ t[1][(b >> 16) & 0xFFU] ^ t[0][b >> 24];
  }
  for (; size > 0; --size, ++data) c = t[0][(c ^ *data) & 0xFFU] ^ (c >> 8);
  return c ^ 0xFFFFFFFFU;
}

/// Describes why these bytes are not a complete PNG file, "" if every chunk is intact.
/// OpenCV would decode a part of a truncated file, and libpng would write to stderr.
inline std::string png_fault(const std::vector<unsigned char>& bytes) {
  static const unsigned char kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  if (bytes.empty()) return "is empty";
  if (bytes.size() < 8 || std::memcmp(bytes.data(), kSignature, 8) != 0) return "is not a PNG image";
  for (std::size_t at = 8;;) {
    if (bytes.size() - at < 12) return "is truncated";
    const std::uint32_t length = big_endian32(&bytes[at]);
    if (length > bytes.size() - at - 12) return "is truncated";
    const unsigned char* type = &bytes[at + 4];
    if (crc32(type, length + 4U) != big_endian32(type + 4 + length))
      return "is damaged (checksum of a chunk)";
    if (std::memcmp(type, "IEND", 4) == 0) return "";
    at += length + 12U;
  }
}

DYNFILTER_INLINE std::vector<unsigned char> read_bytes(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw IoError(path.string() + ": no such file");
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw IoError(path.string() + ": cannot be read");
  const auto size = static_cast<std::size_t>(in.tellg());
  if (size > limits::kMaxImageBytes)
    throw IoError(path.string() + ": has more than " + std::to_string(limits::kMaxImageBytes) + " bytes");
  std::vector<unsigned char> bytes(size);
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) throw IoError(path.string() + ": cannot be read");
  return bytes;
}

using Bytes = std::vector<unsigned char>;

inline bool begins_with(const Bytes& bytes, const char* signature, std::size_t size) {
  return bytes.size() >= size && std::memcmp(bytes.data(), signature, size) == 0;
}

inline std::optional<cv::Size> positive(std::int64_t width, std::int64_t height) {
  constexpr std::int64_t kMost = INT32_MAX;
  if (width < 1 || height < 1 || width > kMost || height > kMost) return std::nullopt;
  return cv::Size(static_cast<int>(width), static_cast<int>(height));
}

inline std::optional<cv::Size> png_size(const Bytes& bytes) {
  if (bytes.size() < 24) return std::nullopt;
  return positive(big_endian32(&bytes[16]), big_endian32(&bytes[20]));
}

/// The size is in the first frame header, SOF0 to SOF15.
inline std::optional<cv::Size> jpeg_size(const Bytes& bytes) {
  for (std::size_t at = 2; at + 9 < bytes.size();) {
    if (bytes[at] != 0xFF) return std::nullopt;
    const unsigned marker = bytes[at + 1];
    if (marker == 0xFF) {  // padding
      ++at;
      continue;
    }
    const bool table = marker == 0xC4 || marker == 0xC8 || marker == 0xCC;
    const auto short_at = [&](std::size_t i) { return (std::int64_t{bytes[i]} << 8) | bytes[i + 1]; };
    if (marker >= 0xC0 && marker <= 0xCF && !table) return positive(short_at(at + 7), short_at(at + 5));
    at += 2 + static_cast<std::size_t>(short_at(at + 2));
  }
  return std::nullopt;
}

inline std::optional<cv::Size> bmp_size(const Bytes& bytes) {
  if (bytes.size() < 26) return std::nullopt;
  const bool os2 = little_endian32(&bytes[14]) == 12;
  if (os2) return positive(bytes[18] | (bytes[19] << 8), bytes[20] | (bytes[21] << 8));
  const auto signed_at = [&](std::size_t i) {
    return std::int64_t{static_cast<std::int32_t>(little_endian32(&bytes[i]))};
  };
  return positive(signed_at(18), std::abs(signed_at(22)));  // a negative height: rows from the top
}

/// Two numbers in text, between blanks and comments.
inline std::optional<cv::Size> pnm_size(const Bytes& bytes) {
  std::int64_t numbers[2] = {0, 0};
  std::size_t at = 2;
  for (std::int64_t& number : numbers) {
    for (; at < bytes.size() && (std::isspace(bytes[at]) != 0 || bytes[at] == '#'); ++at)
      if (bytes[at] == '#')
        while (at + 1 < bytes.size() && bytes[at] != '\n') ++at;
    for (; at < bytes.size() && std::isdigit(bytes[at]) != 0 && number < INT32_MAX; ++at)
      number = 10 * number + (bytes[at] - '0');
  }
  return positive(numbers[0], numbers[1]);
}

DYNFILTER_INLINE std::optional<cv::Size> image_size(const std::vector<unsigned char>& bytes) {
  if (begins_with(bytes, "\x89PNG\r\n\x1A\n", 8)) return png_size(bytes);
  if (begins_with(bytes, "\xFF\xD8", 2)) return jpeg_size(bytes);
  if (begins_with(bytes, "BM", 2)) return bmp_size(bytes);
  if (begins_with(bytes, "P", 1) && bytes.size() > 2 && bytes[1] >= '1' && bytes[1] <= '6')
    return pnm_size(bytes);
  return std::nullopt;
}

inline void check_limits(const std::filesystem::path& path, const cv::Size& size) {
  if (size.width <= limits::kMaxImageSide_px && size.height <= limits::kMaxImageSide_px &&
      std::int64_t{size.width} * size.height <= limits::kMaxImagePixels)
    return;
  throw IoError(path.string() + ": is " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                ", expected at most " + std::to_string(limits::kMaxImageSide_px) + " on a side and " +
                std::to_string(limits::kMaxImagePixels) + " pixels");
}

}  // namespace detail

DYNFILTER_INLINE cv::Mat read_image(const std::filesystem::path& path, int flags, const CheckSize& check) {
  const std::vector<unsigned char> bytes = detail::read_bytes(path);
  if (path.extension() == ".png") {
    if (const std::string fault = detail::png_fault(bytes); !fault.empty()) {
      throw IoError(path.string() + ": " + fault);
    }
  }
  const std::optional<cv::Size> size = detail::image_size(bytes);
  if (!size)
    throw IoError(path.string() + ": cannot be decoded as an image: no PNG, JPEG, BMP or PNM header");
  detail::check_limits(path, *size);
  // OpenCV turns a JPEG as its metadata says, so its size is known when it is decoded.
  const bool may_turn = bytes[0] == 0xFF;
  if (check && !may_turn) check(*size);
  cv::Mat image;
  try {
    image = cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {
  }
  if (image.empty()) throw IoError(path.string() + ": cannot be decoded as an image");
  if (check && may_turn) check(image.size());
  return image;
}

}  // namespace dynfilter::io
