// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace dynfilter::io {

/// Waits until a file's content, or the names in a folder, are on the disk.
/// Throws IoError if the disk cannot take them.
void make_durable(const std::filesystem::path& path);

/// The same for a folder with all that is in it.
void make_tree_durable(const std::filesystem::path& folder);

}  // namespace dynfilter::io
