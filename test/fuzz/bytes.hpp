// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

namespace fuzz {

/// Reads values from a fuzzer's input. Beyond the end everything is zero.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : at_(data), left_(size) {}

  bool empty() const { return left_ == 0; }

  template <class T>
  T take() {
    T value{};
    const std::size_t n = left_ < sizeof(T) ? left_ : sizeof(T);
    if (n > 0) std::memcpy(&value, at_, n);
    at_ += n;
    left_ -= n;
    return value;
  }
  std::uint8_t byte() { return take<std::uint8_t>(); }
  bool flag() { return (byte() & 1U) != 0; }
  /// In [0, n).
  int below(int n) { return byte() % n; }
  std::string rest() {
    std::string text(reinterpret_cast<const char*>(at_), left_);
    at_ += left_;
    left_ = 0;
    return text;
  }

  /// A number that arithmetic or a comparison may get wrong. Some are any bits at all.
  double odd() {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kOdd[] = {kNan, kInf, -kInf, 0,     -0.0, -1,   1e-40, 1e30,       -1e30,       3e9,
                               -3e9, 2e6,  1e38,  1e308, 0.5,  1e-9, 255,   2147483648, -2147483649, 1e19};
    const std::uint8_t which = byte();
    if (which < std::size(kOdd)) return kOdd[which];
    if (which < 200) return static_cast<double>(take<float>());
    return static_cast<double>(static_cast<std::int8_t>(which));
  }

 private:
  const std::uint8_t* at_;
  std::size_t left_;
};

}  // namespace fuzz
