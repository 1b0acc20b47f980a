// SPDX-License-Identifier: MIT
#include "io/output_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <dynfilter/core/error.hpp>
#include <system_error>

namespace dynfilter::io {

namespace detail {

std::filesystem::path place_beside(const std::filesystem::path& target) {
  const std::filesystem::path whole = std::filesystem::absolute(target), parent = whole.parent_path();
  struct stat own {
  }, above{};
  if (::stat(parent.c_str(), &above) != 0 || !S_ISDIR(above.st_mode))
    throw IoError(parent.string() + ": no such folder to write into");
  const bool is_mount_point =
      ::stat(whole.c_str(), &own) == 0 && S_ISDIR(own.st_mode) && own.st_dev != above.st_dev;
  return is_mount_point ? whole : parent;
}

}  // namespace detail

OutputLock::OutputLock(const std::filesystem::path& target)
    : path_(detail::place_beside(target) / ("." + target.filename().string() + ".lock")) {
  while (!take(target.string())) ::close(file_);
}

OutputLock::~OutputLock() {
  if (has_our_file()) ::unlink(path_.c_str());  // before others can lock it
  ::close(file_);
}

inline bool OutputLock::take(const std::string& target) {
  constexpr mode_t kForAll = 0666;  // less the umask
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kForAll);
  if (file_ < 0) throw IoError(target + ": cannot write here: " + std::generic_category().message(errno));
  while (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EINTR) continue;
    if (errno != EWOULDBLOCK) return true;  // no locks on this file system
    ::close(file_);
    throw IoError(target + ": another program is writing here (it holds " + path_.string() + ")");
  }
  return has_our_file();
}

inline bool OutputLock::has_our_file() const {
  struct stat named {
  }, opened{};
  return ::stat(path_.c_str(), &named) == 0 && ::fstat(file_, &opened) == 0 &&
         named.st_ino == opened.st_ino && named.st_dev == opened.st_dev;
}

}  // namespace dynfilter::io
