// SPDX-License-Identifier: MIT
#include "io/sequence_source.hpp"

#include <algorithm>
#include <cctype>
#include <dynfilter/core/error.hpp>
#include <system_error>

#include "io/video_stream.hpp"

namespace dynfilter::io {
namespace {

constexpr const char* kCamera = "camera:";

bool begins_with(const std::string& text, const std::string& begin) {
  return text.compare(0, begin.size(), begin) == 0;
}

}  // namespace

SourceKind kind_of_source(const std::filesystem::path& source) {
  std::error_code error;
  const std::string text = source.string();
  const std::filesystem::file_status status = std::filesystem::status(source, error);
  if (std::filesystem::is_directory(status)) return SourceKind::Folder;
  if (std::filesystem::is_regular_file(status)) {
    if (names_an_image(source))
      throw IoError(text + ": is one image; give its folder, or a pattern as 'frames/*.png'");
    return SourceKind::Video;
  }
  if (std::filesystem::exists(status))
    throw IoError(text + ": is neither a folder nor a file; a device is given as camera:" + text);
  if (begins_with(text, kCamera)) return SourceKind::Camera;
  if (text.find("://") != std::string::npos)
    throw IoError(text + ": no such folder; the address of a stream is given as camera:" + text);
  if (text.find_first_of("*?[") != std::string::npos) return SourceKind::Images;
  throw IoError(text + ": no such folder or file");
}

std::string camera_address(const std::filesystem::path& source) {
  const std::string address = source.string().substr(std::string(kCamera).size());
  if (address.empty()) throw IoError(source.string() + ": give the camera's number, as camera:0");
  return address;
}

bool names_an_image(const std::filesystem::path& file) {
  static constexpr const char* kSuffixes[] = {".png", ".jpg", ".jpeg", ".pgm", ".ppm",
                                              ".bmp", ".tif", ".tiff", ".webp"};
  std::string suffix = file.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(std::begin(kSuffixes), std::end(kSuffixes), [&](const char* s) { return suffix == s; });
}

}  // namespace dynfilter::io
