// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "steady/allocation_count.hpp"

#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define DYNFILTER_ALLOCATION_HOOKS
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define DYNFILTER_ALLOCATION_HOOKS
#endif
#ifdef DYNFILTER_ALLOCATION_HOOKS
#include <sanitizer/allocator_interface.h>

#include <atomic>
#endif

namespace dynfilter_test {

/// The sum of what was allocated since the object was made: at least the peak of it.
/// The program must contain steady/allocation_count.cpp, or be built with the address sanitizer.
class AllocatedBytes {
 public:
#ifdef DYNFILTER_ALLOCATION_HOOKS
  AllocatedBytes() {
    static const int installed = __sanitizer_install_malloc_and_free_hooks(on_allocation, on_release);
    works_ = installed != 0;
    begin_ = total();
  }
  std::size_t bytes() const {
    return total() - begin_;
  }
  bool works() const {
    return works_;
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
  bool works_ = false;
#else
  std::size_t bytes() const {
    return count_.bytes();
  }
  bool works() const {
    return AllocationCount::works();
  }

 private:
  AllocationCount count_;
#endif
};

}  // namespace dynfilter_test
