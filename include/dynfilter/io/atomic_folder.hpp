// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <filesystem>

namespace dynfilter::io {

/// A folder of results that appears only when it is complete.
/// Fill path(), then call commit().
/// Without commit(), for example after an exception, it is removed.
/// If the final folder exists, new entries replace those of the same name.
/// Its other entries remain.
class AtomicFolder {
 public:
  /// Throws IoError if `folder` is an existing file or its parent is not writable.
  explicit AtomicFolder(const std::filesystem::path& folder);
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;
  ~AtomicFolder();

  /// The folder to write to until commit().
  const std::filesystem::path& path() const { return path_; }

  void commit();

 private:
  static std::filesystem::path without_trailing_slash(const std::filesystem::path& folder);

  void replace_entries();

  std::filesystem::path final_, path_;
};

}  // namespace dynfilter::io

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/atomic_folder-inl.hpp>
#endif
