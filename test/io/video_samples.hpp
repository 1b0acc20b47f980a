// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <utility>
#include <vector>

#include "doctest/doctest.h"
#include "io/tum_folder.hpp"

namespace dynfilter_test {

constexpr int kGreyStep = 8;  ///< the compression changes a grey level by less than half of it

/// Frame i is uniformly of the grey level kGreyStep * i. `.avi` is Motion JPEG, `.mp4` MPEG-4.
inline void write_video(const std::filesystem::path& path, int frames, cv::Size size = {64, 48},
                        double rate_hz = 10) {
  const bool avi = path.extension() == ".avi";
  const int codec =
      avi ? cv::VideoWriter::fourcc('M', 'J', 'P', 'G') : cv::VideoWriter::fourcc('m', 'p', '4', 'v');
  cv::VideoWriter writer(path.string(), cv::CAP_FFMPEG, codec, rate_hz, size);
  REQUIRE(writer.isOpened());
  for (int i = 0; i < frames; ++i) writer.write(cv::Mat(size, CV_8UC3, cv::Scalar::all(kGreyStep * i % 256)));
}

/// Big-endian numbers in a file's bytes.
inline std::uint32_t number_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  return value;
}
inline std::string number(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xFFU);
  return bytes;
}

/// Replaces the table of durations of an MP4 whose tables are behind its images: {frames, duration} each.
/// The first entry of the table that is there tells the duration of one frame.
inline void set_durations(const std::filesystem::path& path,
                          const std::vector<std::pair<std::uint32_t, double>>& frames_and_lengths) {
  std::string bytes = read_text(path);
  const std::size_t stts = bytes.find("stts"), mdat = bytes.find("mdat");
  REQUIRE(stts != std::string::npos);
  REQUIRE(mdat < stts);
  const std::uint32_t old_size = number_at(bytes, stts - 4), unit = number_at(bytes, stts + 16);
  std::string table = number(0) + number(static_cast<std::uint32_t>(frames_and_lengths.size()));
  for (const auto& [frames, length] : frames_and_lengths)
    table += number(frames) + number(static_cast<std::uint32_t>(length * unit));
  const auto size = static_cast<std::uint32_t>(8 + table.size());
  bytes.replace(stts + 4, old_size - 8, table);
  bytes.replace(stts - 4, 4, number(size));
  for (const char* box : {"moov", "trak", "mdia", "minf", "stbl"}) {
    const std::size_t at = bytes.find(box, mdat) - 4;
    bytes.replace(at, 4, number(number_at(bytes, at) + size - old_size));
  }
  write_text(path, bytes);
}

/// As a phone marks a video that it took upright: a quarter turn to the right.
inline void turn_video(const std::filesystem::path& path) {
  std::string bytes = read_text(path);
  const std::size_t matrix = bytes.find("tkhd") + 4 + 40;  // a version 0 header: 40 bytes before its matrix
  const std::uint32_t one = 0x10000, minus_one = 0xFFFF0000;
  bytes.replace(matrix, 20, number(0) + number(one) + number(0) + number(minus_one) + number(0));
  write_text(path, bytes);
}

/// Overwrites the n-th JPEG of a Motion JPEG file, so that it cannot be decoded.
inline void break_frame(const std::filesystem::path& path, int n) {
  std::string bytes = read_text(path);
  std::size_t at = bytes.find("\xFF\xD8\xFF");
  for (int k = 0; k < n; ++k) at = bytes.find("\xFF\xD8\xFF", at + 1);
  REQUIRE(at != std::string::npos);
  bytes.replace(at, 200, std::string(200, '\0'));
  write_text(path, bytes);
}

}  // namespace dynfilter_test
