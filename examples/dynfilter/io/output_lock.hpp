// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace dynfilter::io {

namespace detail {

/// The folder for hidden files of an output: its parent, or itself if it is a mount point.
/// Throws IoError if there is no such folder.
std::filesystem::path place_beside(const std::filesystem::path& target);

}  // namespace detail

/// Reserves a file or folder for one writer among all programs, by flock() on `.NAME.lock`.
/// The lock ends with the program, however it ends. An unused lock file has no effect.
/// File systems without locks are not locked.
class OutputLock {
 public:
  /// The lock file is beside `target`, or in it if it is a mount point.
  /// Throws IoError if another program holds it.
  explicit OutputLock(const std::filesystem::path& target);
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;
  ~OutputLock();

 private:
  /// False if the lock file was removed meanwhile.
  bool take(const std::string& target);
  bool has_our_file() const;

  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace dynfilter::io
