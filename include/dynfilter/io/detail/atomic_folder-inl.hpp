// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/atomic_folder.hpp>

#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/io/atomic_file.hpp>
#include <system_error>

namespace dynfilter::io {

DYNFILTER_INLINE AtomicFolder::AtomicFolder(const std::filesystem::path& folder)
    : final_(without_trailing_slash(folder)) {
  std::error_code error;
  if (std::filesystem::exists(final_, error) && !std::filesystem::is_directory(final_, error)) {
    throw IoError(final_.string() + ": exists and is not a folder");
  }
  const std::filesystem::path parent = final_.parent_path();
  if (!std::filesystem::is_directory(parent, error)) {
    throw IoError(parent.string() + ": no such folder to write into");
  }
  path_ = detail::temporary_beside(final_);
  if (!std::filesystem::create_directory(path_, error)) {
    throw IoError(final_.string() + ": cannot write here");
  }
}

DYNFILTER_INLINE AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

DYNFILTER_INLINE void AtomicFolder::commit() {
  std::error_code error;
  if (std::filesystem::exists(final_, error)) {
    replace_entries();
    std::filesystem::remove_all(path_, error);
  } else {
    detail::rename_or_throw(path_, final_);
  }
  path_.clear();
}

inline std::filesystem::path AtomicFolder::without_trailing_slash(const std::filesystem::path& folder) {
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

inline void AtomicFolder::replace_entries() {
  for (const auto& entry : std::filesystem::directory_iterator(path_)) {
    const std::filesystem::path target = final_ / entry.path().filename();
    std::error_code error;
    if (std::filesystem::is_directory(target, error)) std::filesystem::remove_all(target, error);
    detail::rename_or_throw(entry.path(), target);
  }
}

}  // namespace dynfilter::io
