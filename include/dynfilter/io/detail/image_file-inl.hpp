// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/image_file.hpp>

#include <array>
#include <cstring>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
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
  std::vector<unsigned char> bytes(static_cast<std::size_t>(in.tellg()));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) throw IoError(path.string() + ": cannot be read");
  return bytes;
}

}  // namespace detail

DYNFILTER_INLINE cv::Mat read_image(const std::filesystem::path& path, int flags) {
  const std::vector<unsigned char> bytes = detail::read_bytes(path);
  if (path.extension() == ".png") {
    if (const std::string fault = detail::png_fault(bytes); !fault.empty()) {
      throw IoError(path.string() + ": " + fault);
    }
  }
  cv::Mat image;
  try {
    if (!bytes.empty()) image = cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {
  }
  if (image.empty()) throw IoError(path.string() + ": cannot be decoded as an image");
  return image;
}

}  // namespace dynfilter::io
