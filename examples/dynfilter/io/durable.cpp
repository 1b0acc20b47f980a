// SPDX-License-Identifier: MIT
#include "io/durable.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <cerrno>
#include <dynfilter/core/error.hpp>
#include <system_error>

namespace dynfilter::io {

void make_durable(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  int error = file < 0 || ::fsync(file) != 0 ? errno : 0;
  const bool nothing_to_wait_for = error == EINVAL || error == EROFS;
  const bool not_ours = error == EACCES;  // a file of somebody else, taken over from an older folder
  if (nothing_to_wait_for || not_ours) error = 0;
  if (file >= 0) ::close(file);
  if (error != 0)
    throw IoError(path.string() +
                  ": cannot be written to the disk: " + std::generic_category().message(error));
}

void make_tree_durable(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (!entry.is_symlink() && (entry.is_regular_file() || entry.is_directory())) make_durable(entry.path());
  make_durable(folder);
}

}  // namespace dynfilter::io
