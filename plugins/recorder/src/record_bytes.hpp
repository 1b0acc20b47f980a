// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace dynfilter::recorder {

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "recordings are little-endian"
#endif

/// Elements whose bytes are the same everywhere.
template <class T>
inline constexpr bool kPlain = std::is_arithmetic_v<T> || std::is_enum_v<T>;
template <>
inline constexpr bool kPlain<cv::KeyPoint> = true;
template <>
inline constexpr bool kPlain<cv::Point3f> = true;
static_assert(sizeof(cv::KeyPoint) == 28 && sizeof(cv::Point3f) == 12, "no padding");

/// Appends values to the bytes of a record.
class ByteWriter {
 public:
  static constexpr bool kReads = false;
  explicit ByteWriter(std::vector<char>& bytes) : bytes_(bytes) { bytes_.clear(); }

  template <class T>
  void number(const T& value) {
    static_assert(kPlain<T>);
    raw(&value, sizeof value);
  }
  /// Number of elements of a list, each of which takes `least_bytes` or more.
  template <class List>
  void count(const List& list, std::size_t /*least_bytes*/) {
    number(std::uint64_t{list.size()});
  }
  template <class Values>
  void array(const Values& values) {
    using T = std::remove_const_t<std::remove_pointer_t<decltype(values.data())>>;
    count(values, sizeof(T));
    if constexpr (kPlain<T>)
      raw(values.data(), values.size() * sizeof(T));
    else
      static_assert(kPlain<T>, "write its members");
  }
  void text(const std::string& text) { array(text); }
  /// Rows without their padding.
  void matrix(const cv::Mat& image) {
    number(std::int32_t{image.type()});
    number(std::int32_t{image.dims});
    for (int d = 0; d < image.dims; ++d) number(std::int32_t{image.size[d]});
    const cv::Mat whole = image.isContinuous() ? image : image.clone();
    number(std::uint64_t{whole.total() * whole.elemSize()});
    raw(whole.data, whole.total() * whole.elemSize());
  }

 private:
  void raw(const void* data, std::size_t size) {
    if (size == 0) return;
    const std::size_t at = bytes_.size();
    bytes_.resize(at + size);
    std::memcpy(bytes_.data() + at, data, size);
  }
  std::vector<char>& bytes_;
};

/// Takes the same values from them. Throws Error for what does not fit.
class ByteReader {
 public:
  static constexpr bool kReads = true;
  explicit ByteReader(const std::vector<char>& bytes) : at_(bytes.data()), left_(bytes.size()) {}

  template <class T>
  void number(T& value) {
    static_assert(kPlain<T> && !std::is_same_v<T, bool>);
    take(&value, sizeof value);
  }
  void number(bool& value) {
    std::uint8_t byte = 0;
    take(&byte, 1);
    value = byte != 0;
  }
  template <class List>
  void count(List& list, std::size_t least_bytes) {
    list.clear();
    list.resize(counted(least_bytes));
  }
  template <class T>
  void array(std::vector<T>& values) {
    count(values, sizeof(T));
    if (!values.empty()) take(values.data(), values.size() * sizeof(T));
  }
  void text(std::string& text) {
    count(text, 1);
    if (!text.empty()) take(text.data(), text.size());
  }
  void matrix(cv::Mat& image) {
    std::int32_t type = 0, dims = 0;
    number(type), number(dims);
    if ((type & ~CV_MAT_TYPE_MASK) != 0 || dims < 0 || dims > kMostDims) fail();
    std::vector<int> sizes(static_cast<std::size_t>(dims));
    // A product beyond this many bytes cannot be in the record.
    std::uint64_t elements = dims == 0 ? 0 : 1;
    for (int& size : sizes) {
      number(size);
      if (size < 0 || (size > 0 && elements > left_ / static_cast<std::uint64_t>(size))) fail();
      elements *= static_cast<std::uint64_t>(size);
    }
    std::uint64_t bytes = 0;
    number(bytes);
    if (bytes > left_ || elements * CV_ELEM_SIZE(type) != bytes) fail();
    image.release();
    if (bytes == 0) return;
    image.create(dims, sizes.data(), type);
    take(image.data, static_cast<std::size_t>(bytes));
  }
  void finish() const {
    if (left_ != 0) fail();
  }
  static constexpr int kMostDims = 32;  ///< of OpenCV's matrices
  [[noreturn]] static void fail() { throw Error("does not hold what it says"); }

 private:
  std::size_t counted(std::size_t least_bytes) {
    std::uint64_t n = 0;
    number(n);
    if (n > left_ / least_bytes) fail();
    return static_cast<std::size_t>(n);
  }
  void take(void* to, std::size_t size) {
    if (size > left_) fail();
    std::memcpy(to, at_, size);
    at_ += size, left_ -= size;
  }
  const char* at_;
  std::size_t left_;
};

/// The value of an optional, after whether there is one.
template <class Archive, class Optional, class Body>
void transfer_optional(Archive& archive, Optional& value, const Body& body) {
  bool there = value.has_value();
  archive.number(there);
  if constexpr (Archive::kReads) {
    value.reset();
    if (there) value.emplace();
  }
  if (there) body(*value);
}

/// An enumeration of `count` values.
template <class Archive, class E>
void transfer_choice(Archive& archive, E& value, int count) {
  auto byte = static_cast<std::uint8_t>(value);
  archive.number(byte);
  if constexpr (Archive::kReads) {
    if (byte >= count) ByteReader::fail();
    value = static_cast<E>(byte);
  }
}

}  // namespace dynfilter::recorder
