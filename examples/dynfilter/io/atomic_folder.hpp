// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <filesystem>

#include "io/output_lock.hpp"

namespace dynfilter::io {

/// What happens to entries of an existing folder that the new results do not replace.
enum class OtherEntries { Keep, Remove };

/// A folder of results that appears only when it is complete, for one writer at a time.
/// Fill path(), then call commit().
/// Without commit(), for example after an exception, it is removed.
///
/// commit() replaces an existing folder by one rename, after the new one is on the disk.
/// A reader or a power cut sees the old results or the new ones.
/// Entries are replaced one after the other if the folder is a mount point or the working directory. The same
/// holds if its file system cannot exchange two folders.
class AtomicFolder {
 public:
  /// Throws IoError if `folder` is an existing file, its parent is not writable, or another writer has it.
  explicit AtomicFolder(const std::filesystem::path& folder, OtherEntries others = OtherEntries::Keep);
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;
  ~AtomicFolder();

  /// The folder to write to until commit().
  const std::filesystem::path& path() const { return path_; }

  void commit();

 private:
  static std::filesystem::path resolved(const std::filesystem::path& folder);

  void remove_abandoned() const;
  bool exchange();
  void take_over_others() const;
  void replace_entries() const;

  std::filesystem::path final_;
  OutputLock lock_;
  std::filesystem::path place_;  ///< folder of path_
  std::filesystem::path path_;
  OtherEntries others_;
};

}  // namespace dynfilter::io
