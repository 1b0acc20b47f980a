// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <ostream>

namespace dynfilter::io {

namespace detail {

/// Temporary names are `.NAME.partial-` and so many hexadecimal digits.
inline constexpr const char* kPartial = ".partial-";
inline constexpr std::size_t kPartialDigits = 8;

/// A unique name beside `path`. rename() is atomic only within one file system.
std::filesystem::path temporary_beside(const std::filesystem::path& path);

void rename_or_throw(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace detail

/// Writes a file under a temporary name and renames it at the end, when it is on the disk.
/// A reader or a power cut sees the old file or the complete new one.
/// Throws IoError. Exceptions of `write` pass through, and no temporary file remains.
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(std::ostream&)>& write);

}  // namespace dynfilter::io
