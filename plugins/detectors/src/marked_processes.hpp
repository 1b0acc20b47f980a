// SPDX-License-Identifier: MIT
#pragma once

#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill() is POSIX's
#include <sys/syscall.h>
#include <unistd.h>
#include <cstdlib>
#include <dynfilter/config/numbers.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <system_error>

namespace dynfilter::detail {

/// `NAME=value` with a value that no other process has. Children inherit it, also across setsid().
inline std::string new_process_mark() {
  std::random_device device;
  std::string mark = "DYNFILTER_PROVIDER=" + std::to_string(::getpid()) + "-";
  for (int i = 0; i < 16; ++i) mark += "0123456789abcdef"[device() % 16];
  return mark;
}

/// False also for processes that may not be read, which are those of other users.
inline bool has_mark(const std::filesystem::path& process, const std::string& mark) {
  std::ifstream in(process / "environ", std::ios::binary);
  const std::string variables{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const std::string whole = '\0' + mark + '\0';
  return ('\0' + variables).find(whole) != std::string::npos;
}

/// A number may be another process's by the time that it is killed. A descriptor is not.
inline bool kill_if_marked(const std::filesystem::path& process, const std::string& mark) {
  const auto pid = static_cast<pid_t>(std::atol(process.filename().c_str()));
#if defined(SYS_pidfd_open) && defined(SYS_pidfd_send_signal)
  const auto descriptor = static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  const bool ours = has_mark(process, mark);
  if (descriptor >= 0) {
    if (ours) ::syscall(SYS_pidfd_send_signal, descriptor, SIGKILL, nullptr, 0);
    ::close(descriptor);
    return ours;
  }
#else
  const bool ours = has_mark(process, mark);
#endif
  if (ours) ::kill(pid, SIGKILL);
  return ours;
}

/// Kills the processes that have the mark in their environment, until there are none.
/// Those that removed it from their environment are not found, nor is any without /proc.
inline void kill_marked(const std::string& mark) {
  constexpr int kMostRounds = 20;  // a process may start others while it is looked for
  bool any = true;
  for (int round = 0; any && round < kMostRounds; ++round) {
    any = false;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/proc", error))
      if (is_digit(entry.path().filename().c_str()[0])) any = kill_if_marked(entry.path(), mark) || any;
  }
}

}  // namespace dynfilter::detail
