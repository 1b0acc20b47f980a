// SPDX-License-Identifier: MIT
#include "io/ply.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>
#include <ostream>
#include <string>

#include "io/atomic_file.hpp"

namespace dynfilter::io {

namespace detail {

template <class T>
void append_little_endian(std::string& bytes, T value) {
  std::uint32_t bits = 0;
  static_assert(sizeof(T) == sizeof(bits));
  std::memcpy(&bits, &value, sizeof(bits));
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((bits >> shift) & 0xFFU);
}

}  // namespace detail

void write_ply(const std::filesystem::path& path, const std::vector<cv::Point3f>& points_m,
               const std::vector<cv::Vec3b>& colours, const std::vector<int>& classes) {
  const std::size_t n = points_m.size();
  if ((!colours.empty() && colours.size() != n) || (!classes.empty() && classes.size() != n)) {
    throw IoError(path.string() + ": colours and classes need one entry per point, or none");
  }
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(n) +
                      "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!colours.empty()) bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!classes.empty()) bytes += "property int class\n";
  bytes += "end_header\n";
  for (std::size_t i = 0; i < n; ++i) {
    for (const float v : {points_m[i].x, points_m[i].y, points_m[i].z})
      detail::append_little_endian(bytes, v);
    if (!colours.empty()) {
      for (int channel = 2; channel >= 0; --channel) bytes += static_cast<char>(colours[i][channel]);
    }
    if (!classes.empty()) detail::append_little_endian(bytes, static_cast<std::int32_t>(classes[i]));
  }
  write_file_atomically(
      path, [&](std::ostream& out) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
}

}  // namespace dynfilter::io
