// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "steady/allocation_count.hpp"

#ifdef __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define DYNFILTER_ALLOCATION_HOOKS
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DYNFILTER_ALLOCATION_HOOKS
#endif
#ifdef DYNFILTER_ALLOCATION_HOOKS
#include <atomic>

// GCC has the function, but not the header that declares it.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));
#endif

namespace dynfilter_test {

/// The sum of what was allocated since the object was made: at least the peak of it.
/// The program must contain steady/allocation_count.cpp, or be built with a sanitizer.
class AllocatedBytes {
 public:
#ifdef DYNFILTER_ALLOCATION_HOOKS
  AllocatedBytes() {
    static const int installed = __sanitizer_install_malloc_and_free_hooks(on_allocation, on_release);
    (void)installed;
    begin_ = total();
  }
  std::size_t bytes() const {
    return total() - begin_;
  }

 private:
  static std::atomic<std::size_t>& total() {
    static std::atomic<std::size_t> bytes{0};
    return bytes;
  }
  static void on_allocation(const volatile void*, std::size_t bytes) {
    total() += bytes;
  }
  static void on_release(const volatile void*) {}

  std::size_t begin_ = 0;
#else
  std::size_t bytes() const {
    return count_.bytes();
  }

 private:
  AllocationCount count_;
#endif
};

}  // namespace dynfilter_test
