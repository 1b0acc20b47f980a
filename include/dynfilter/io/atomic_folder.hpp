// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/atomic_file.hpp>
#include <filesystem>
#include <string>
#include <system_error>

namespace dynfilter::io {

/// A folder of results that appears only when it is complete.
/// Fill path(), then call commit().
/// Without commit(), for example after an exception, it is removed.
/// If the final folder exists, new entries replace those of the same name.
/// Its other entries remain.
class AtomicFolder {
 public:
  /// Throws IoError if `folder` is an existing file or its parent is not writable.
  explicit AtomicFolder(const std::filesystem::path& folder) : final_(without_trailing_slash(folder)) {
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
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;
  ~AtomicFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }

  /// The folder to write to until commit().
  const std::filesystem::path& path() const { return path_; }

  void commit() {
    std::error_code error;
    if (std::filesystem::exists(final_, error)) {
      replace_entries();
      std::filesystem::remove_all(path_, error);
    } else {
      detail::rename_or_throw(path_, final_);
    }
    path_.clear();
  }

 private:
  static std::filesystem::path without_trailing_slash(const std::filesystem::path& folder) {
    const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
    return whole.has_filename() ? whole : whole.parent_path();
  }

  void replace_entries() {
    for (const auto& entry : std::filesystem::directory_iterator(path_)) {
      const std::filesystem::path target = final_ / entry.path().filename();
      std::error_code error;
      if (std::filesystem::is_directory(target, error)) std::filesystem::remove_all(target, error);
      detail::rename_or_throw(entry.path(), target);
    }
  }

  std::filesystem::path final_, path_;
};

}  // namespace dynfilter::io
