// SPDX-License-Identifier: MIT
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <dynfilter/core/error.hpp>
#include <string>
#include <vector>

extern "C" char** environ;  // NOLINT: POSIX wants it declared

namespace dynfilter {

/// A program with standard input and output on one socket, and the caller's standard error.
/// It runs in its own process group and inherits no other close-on-exec descriptor.
/// A variable in its environment marks it and all programs that it starts.
/// The destructor ends it: it closes the socket, and kills the program if it does not exit.
class ChildProcess {
 public:
  /// `argv[0]` is searched in PATH. Throws Error if it cannot be started.
  explicit ChildProcess(const std::vector<std::string>& argv);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  ~ChildProcess();

  int socket() const { return socket_; }  ///< its descriptor, of the host's side
  pid_t pid() const { return pid_; }      ///< of the process

  /// Kills the program, its process group, and programs with its mark that left the group (setsid).
  /// Returns how it ended: "exit code 1", "signal 9"; empty if unknown.
  std::string kill_now();

 private:
  static constexpr int kGrace_ms = 300;

  static Error failure(const std::string& program, int error);

  int spawn(const std::vector<std::string>& argv, int theirs);

  int socket_ = -1;
  pid_t pid_ = -1;
  std::string mark_;
};

}  // namespace dynfilter
