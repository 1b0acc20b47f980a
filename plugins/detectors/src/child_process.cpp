// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/child_process.hpp>

#include <cstring>
#include "marked_processes.hpp"

namespace dynfilter {

ChildProcess::ChildProcess(const std::vector<std::string>& argv) : mark_(detail::new_process_mark()) {
  if (argv.empty() || argv[0].empty()) throw Error("no command to start");
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) throw failure(argv[0], errno);
  // Above the standard descriptors: dup2 onto itself would keep the close-on-exec flag.
  const int theirs = ::fcntl(ends[1], F_DUPFD_CLOEXEC, 3);
  ::close(ends[1]);
  socket_ = ends[0];
  const int error = theirs < 0 ? errno : spawn(argv, theirs);
  if (theirs >= 0) ::close(theirs);
  if (error == 0) return;
  ::close(socket_);
  throw failure(argv[0], error);
}

ChildProcess::~ChildProcess() {
  ::shutdown(socket_, SHUT_WR);
  pollfd gone{socket_, POLLIN, 0};
  char rest[256];
  // Waits until the program closes its end, and discards its remaining output.
  for (int i = 0; i < 8 && ::poll(&gone, 1, kGrace_ms) > 0; ++i)
    if (::recv(socket_, rest, sizeof(rest), MSG_DONTWAIT) <= 0) break;
  kill_now();
  ::close(socket_);
}

std::string ChildProcess::kill_now() {
  if (pid_ <= 0) return {};
  int status = 0;
  pid_t ended = -1;
  ::kill(-pid_, SIGKILL);  // before waitpid(), after which the number may be another group's
  while ((ended = ::waitpid(pid_, &status, 0)) < 0 && errno == EINTR) {
  }
  detail::kill_marked(mark_);
  const bool known = ended == pid_;
  pid_ = -1;
  if (!known) return {};
  return WIFEXITED(status) ? "exit code " + std::to_string(WEXITSTATUS(status))
                           : "signal " + std::to_string(WTERMSIG(status));
}

inline Error ChildProcess::failure(const std::string& program, int error) {
  return Error(program + ": cannot be started: " + std::strerror(error));  // NOLINT: one thread starts
}

int ChildProcess::spawn(const std::vector<std::string>& argv, int theirs) {
  std::vector<char*> arguments;
  for (const std::string& word : argv) arguments.push_back(const_cast<char*>(word.c_str()));  // NOLINT
  arguments.push_back(nullptr);
  std::vector<char*> variables;
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable)
    if (std::strncmp(*variable, mark_.c_str(), mark_.find('=') + 1) != 0) variables.push_back(*variable);
  variables.push_back(mark_.data());
  variables.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, theirs, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, theirs, STDOUT_FILENO);
  posix_spawnattr_t how;
  posix_spawnattr_init(&how);
  sigset_t none, defaults;
  sigemptyset(&none);
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigmask(&how, &none);
  posix_spawnattr_setsigdefault(&how, &defaults);
  posix_spawnattr_setpgroup(&how, 0);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  const int error = ::posix_spawnp(&pid_, arguments[0], &files, &how, arguments.data(), variables.data());
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&how);
  if (error != 0) pid_ = -1;
  return error;
}

}  // namespace dynfilter
