// SPDX-License-Identifier: MIT
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/limits.hpp>
#include <functional>
#include <string>
#include <utility>

namespace dynfilter {

/// The other side has closed the stream.
class EndOfStream : public Error {
 public:
  EndOfStream() : Error("the other side closed the connection") {}
};

/// Lines and bytes over a socket or a pair of pipes, with a deadline.
/// Throws EndOfStream if the other side closes the stream, and Error for other failures, such as a timeout or
/// a line that is too long.
/// Never raises SIGPIPE on a socket.
class MessageStream {
 public:
  static constexpr double kForever = 1e9;

  /// Does not own the descriptors.
  MessageStream(int in, int out) : in_(in), out_(out) {}

  /// Sets the time limit for the next calls.
  void set_deadline(double seconds);

  /// While it waits, a call calls `stop` at least every kStop_ms. If that returns true, the wait throws
  /// Error.
  void set_stop(std::function<bool()> stop) { stop_ = std::move(stop); }

  /// Returns a line without its line end.
  std::string read_line();

  void read_bytes(unsigned char* to, std::size_t n);  ///< exactly n bytes

  /// Discards what the other side has sent so far, without waiting.
  /// Throws Error beyond limits::kMaxSurplusBytes.
  void discard_unread();

  void write_text(const std::string& text) { write_bytes(text.data(), text.size()); }  ///< all of the text

  void write_bytes(const void* from, std::size_t n);  ///< all n bytes

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMaxLine = limits::kMaxMessageLineBytes;
  static constexpr int kStop_ms = 100;

  std::size_t receive(void* to, std::size_t n);

  void wait(int descriptor, short events) const;
  int wait_ms() const;
  std::string shown_seconds() const;

  int in_, out_;
  double seconds_ = kForever;
  Clock::time_point end_;
  std::function<bool()> stop_;
  std::string buffer_;
  std::size_t begin_ = 0;
};

}  // namespace dynfilter
