// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace dynfilter_test {

/// Calls of malloc, realloc, operator new and the like, of all threads, while one of these exists.
/// The program must contain allocation_count.cpp.
class AllocationCount {
 public:
  AllocationCount();
  AllocationCount(const AllocationCount&) = delete;
  AllocationCount& operator=(const AllocationCount&) = delete;
  ~AllocationCount();

  std::size_t calls() const;
  std::size_t bytes() const;

  /// False under a sanitizer, which has its own allocator.
  static bool works();
};

}  // namespace dynfilter_test
