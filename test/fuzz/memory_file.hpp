// SPDX-License-Identifier: MIT
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <string>

#include "target.hpp"

namespace fuzz {

/// A file that is nowhere on a disk, for readers that want a path or a descriptor.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& content = "") : fd_(memfd_create("fuzz", 0)) {
    require(fd_ >= 0, "memfd_create works here");
    for (std::size_t done = 0; done < content.size();) {
      const ssize_t n = ::write(fd_, content.data() + done, content.size() - done);
      require(n > 0, "a file in memory can be written");
      done += static_cast<std::size_t>(n);
    }
    rewind();
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(fd_); }

  int fd() const { return fd_; }
  void rewind() const { ::lseek(fd_, 0, SEEK_SET); }
  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

}  // namespace fuzz
