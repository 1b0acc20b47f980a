// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <csetjmp>
#include <cstdio>
#include <dynfilter/detectors/decoded_image.hpp>
#include <string>

namespace dynfilter::io::detail {

/// Calls of a C library, of its decoder or encoder, whose errors must leave it by a long jump. What is
/// allocated is freed by the destructor of the derived class, after the jump.
class CCodec {
 public:
  CCodec() = default;
  CCodec(const CCodec&) = delete;
  CCodec& operator=(const CCodec&) = delete;

 protected:
  ~CCodec() = default;

  /// Throws ImageFault if one of the calls left. They must not throw, and have no variables with destructors.
  template <class Calls>
  void run(const Calls& calls) {
    if (!returns(calls)) throw ImageFault(fault_.data());
  }

  static bool little_endian() {
    const unsigned short one = 1;
    return *reinterpret_cast<const unsigned char*>(&one) == 1;
  }

  [[noreturn]] void leave(const char* fault) {
    std::snprintf(fault_.data(), fault_.size(), "%s", fault);
    std::longjmp(target_, 1);
  }

  /// A warning is an error, too: the decoder would fill in what is missing.
  [[noreturn]] void leave_damaged(const char* library, const char* message) {
    std::snprintf(fault_.data(), fault_.size(), "is damaged (%s: %s)", library, message);
    std::longjmp(target_, 1);
  }

 private:
  static constexpr std::size_t kMaxFault = 256;

  template <class Calls>
  bool returns(const Calls& calls) {
    if (setjmp(target_) != 0) return false;
    calls();
    return true;
  }

  std::jmp_buf target_{};
  std::array<char, kMaxFault> fault_{};
};

}  // namespace dynfilter::io::detail
