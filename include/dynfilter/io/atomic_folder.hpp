// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/atomic_file.hpp>
#include <filesystem>
#include <string>
#include <system_error>

namespace dynfilter::io {

/// A folder of results that appears only when it is complete: fill path(), then commit(). Without a commit
/// (an exception on the way) it is removed again. When the final folder exists already, the new entries
/// replace those of the same name and everything else there stays.
class AtomicFolder {
 public:
  /// Throws IoError when `folder` is an existing file or nothing can be written beside it.
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

  /// Where to write until commit().
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
