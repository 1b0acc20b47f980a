// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

namespace dynfilter {

/// A non-owning view of contiguous elements, like std::span of C++20.
/// It is cheap to copy and must not outlive the elements.
template <class T>
class Span {
  using Value = std::remove_const_t<T>;

 public:
  constexpr Span() noexcept = default;
  constexpr Span(T* data, std::size_t size) noexcept : data_(data), size_(size) {}
  Span(std::vector<Value>& values) noexcept : data_(values.data()), size_(values.size()) {}
  template <class U = T, class = std::enable_if_t<std::is_const_v<U>>>
  Span(const std::vector<Value>& values) noexcept : data_(values.data()), size_(values.size()) {}

  constexpr T* data() const noexcept { return data_; }
  constexpr std::size_t size() const noexcept { return size_; }
  constexpr bool empty() const noexcept { return size_ == 0; }
  constexpr T* begin() const noexcept { return data_; }
  constexpr T* end() const noexcept { return data_ + size_; }
  constexpr T& operator[](std::size_t i) const noexcept { return data_[i]; }  ///< not checked

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace dynfilter
