// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <csignal>
#include <cstring>
#include <exception>
#include <initializer_list>

namespace dynfilter::command {

/// SIGINT, SIGTERM or SIGHUP arrived.
struct Interrupted : std::exception {
  explicit Interrupted(int number) : signal(number) {}
  const char* what() const noexcept override { return "interrupted"; }
  int signal;
};

/// Ends a command that writes files by an exception, so that destructors remove what is incomplete.
/// A second signal ends the program at once.
class Interruption {
 public:
  /// From now on. Signals that the program was started to ignore (nohup) remain ignored.
  static void watch() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      struct sigaction old {};
      if (::sigaction(signal, nullptr, &old) != 0 || old.sa_handler == SIG_IGN) continue;
      struct sigaction noted {};
      noted.sa_handler = &note;
      noted.sa_flags = static_cast<int>(SA_RESETHAND);
      ::sigaction(signal, &noted, nullptr);
    }
  }

  /// Throws Interrupted after a signal. Work that takes long calls this between its steps.
  static void check() {
    if (const int signal = noted(); signal != 0) throw Interrupted(signal);
  }

  /// The signal that arrived, or 0.
  static int noted() { return noted_; }

  /// Ends the program by the signal, as its parent expects.
  [[noreturn]] static void end_by(int signal) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
    std::_Exit(128 + signal);  // the signal is blocked
  }

 private:
  static void note(int signal) { noted_ = signal; }

  static inline volatile std::sig_atomic_t noted_ = 0;
};

}  // namespace dynfilter::command
