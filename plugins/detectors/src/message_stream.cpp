// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/message_stream.hpp>

#include <algorithm>
#include <cstring>
#include <dynfilter/config/numbers.hpp>

namespace dynfilter {

void MessageStream::set_deadline(double seconds) {
  seconds_ = seconds;
  end_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

std::string MessageStream::read_line() {
  for (;;) {
    const std::size_t end = buffer_.find('\n', begin_);
    if (end != std::string::npos) {
      if (end - begin_ > kMaxLine) throw Error("a line of more than " + std::to_string(kMaxLine) + " bytes");
      std::string line = buffer_.substr(begin_, end - begin_);
      begin_ = end + 1;
      return line;
    }
    if (buffer_.size() - begin_ > kMaxLine)
      throw Error("a line of more than " + std::to_string(kMaxLine) + " bytes");
    buffer_.erase(0, begin_);
    begin_ = 0;
    char chunk[4096];
    buffer_.append(chunk, receive(chunk, sizeof(chunk)));
  }
}

void MessageStream::read_bytes(unsigned char* to, std::size_t n) {
  const std::size_t known = std::min(n, buffer_.size() - begin_);
  if (known > 0) std::memcpy(to, buffer_.data() + begin_, known);
  begin_ += known;
  for (std::size_t done = known; done < n;) done += receive(to + done, n - done);
}

void MessageStream::discard_unread() {
  std::size_t discarded = buffer_.size() - begin_;
  buffer_.clear();
  begin_ = 0;
  char chunk[4096];
  for (pollfd watched{in_, POLLIN, 0}; ::poll(&watched, 1, 0) > 0;) {
    ssize_t got = ::recv(in_, chunk, sizeof(chunk), MSG_DONTWAIT);
    if (got < 0 && errno == ENOTSOCK) got = ::read(in_, chunk, sizeof(chunk));
    if (got <= 0) return;  // the next call reports the end
    discarded += static_cast<std::size_t>(got);
    if (discarded > limits::kMaxSurplusBytes)
      throw Error("more than " + std::to_string(limits::kMaxSurplusBytes) + " bytes that answer no image");
  }
}

void MessageStream::write_bytes(const void* from, std::size_t n) {
  const char* bytes = static_cast<const char*>(from);
  for (std::size_t done = 0; done < n;) {
    wait(out_, POLLOUT);
    ssize_t sent = ::send(out_, bytes + done, n - done, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == ENOTSOCK)
      sent = ::write(out_, bytes + done, std::min<std::size_t>(n - done, 4096));
    if (sent > 0) done += static_cast<std::size_t>(sent);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) throw EndOfStream();
  }
}

inline std::size_t MessageStream::receive(void* to, std::size_t n) {
  for (;;) {
    wait(in_, POLLIN);
    ssize_t got = ::recv(in_, to, n, MSG_DONTWAIT);
    if (got < 0 && errno == ENOTSOCK) got = ::read(in_, to, n);
    if (got > 0) return static_cast<std::size_t>(got);
    if (got == 0 || (errno != EAGAIN && errno != EINTR)) throw EndOfStream();
  }
}

inline void MessageStream::wait(int descriptor, short events) const {
  for (;;) {
    if (stop_ && stop_()) throw Error("stopped");
    pollfd watched{descriptor, events, 0};
    const int ready = ::poll(&watched, 1, wait_ms());
    if (ready > 0) return;
    if (ready < 0 && errno != EINTR) throw EndOfStream();
  }
}

/// The time of the next poll. Negative: without an end.
inline int MessageStream::wait_ms() const {
  long long most_ms = -1;
  if (seconds_ < kForever) {
    most_ms = std::chrono::duration_cast<std::chrono::milliseconds>(end_ - Clock::now()).count();
    if (most_ms <= 0) throw Error("no answer within " + shown_seconds());
  }
  if (stop_ && (most_ms < 0 || most_ms > kStop_ms)) most_ms = kStop_ms;
  return static_cast<int>(std::min<long long>(most_ms, 3600000));
}

inline std::string MessageStream::shown_seconds() const {
  return number_text(seconds_) + " s";
}

}  // namespace dynfilter
