// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace dynfilter::io {

/// What a user named as a sequence.
enum class SourceKind {
  Folder,
  Video,   ///< a file
  Camera,  ///< camera:0
  Images   ///< a pattern of file names
};

/// What exists is a folder or a file, whatever its name. Throws IoError if it is neither, and no camera or
/// pattern.
SourceKind kind_of_source(const std::filesystem::path& source);

/// "0" of camera:0. Throws IoError if nothing follows the colon.
std::string camera_address(const std::filesystem::path& source);

/// True for the suffix of a picture that is read as one image.
bool names_an_image(const std::filesystem::path& file);

}  // namespace dynfilter::io
