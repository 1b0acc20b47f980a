// SPDX-License-Identifier: MIT
// Replaces the C library's allocation functions, which operator new, OpenCV and Eigen call.
// Each call is counted and passed on.
#include "allocation_count.hpp"

#include <atomic>
#include <cerrno>
#include <cstdlib>

#ifdef DYNFILTER_TRACE_ALLOCATIONS
#include <execinfo.h>
#include <unistd.h>
#endif

#ifdef __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define DYNFILTER_SANITIZER_ALLOCATES
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || \
    defined(DYNFILTER_SANITIZER_ALLOCATES) || !defined(__GLIBC__)
#define DYNFILTER_OWN_ALLOCATOR 0
#else
#define DYNFILTER_OWN_ALLOCATOR 1
#endif

namespace {

std::atomic<bool> counting{false};
std::atomic<std::size_t> counted_calls{0}, counted_bytes{0};

#if DYNFILTER_OWN_ALLOCATOR
void count(std::size_t bytes) {
  if (!counting.load(std::memory_order_relaxed)) return;
  counted_calls.fetch_add(1, std::memory_order_relaxed);
  counted_bytes.fetch_add(bytes, std::memory_order_relaxed);
#ifdef DYNFILTER_TRACE_ALLOCATIONS  // who allocates: one line of addresses for each call
  thread_local bool inside = false;
  if (inside) return;
  inside = true;
  void* frames[24];
  backtrace_symbols_fd(frames, backtrace(frames, 24), STDERR_FILENO);
  (void)!write(STDERR_FILENO, "--\n", 3);
  inside = false;
#endif
}
#endif

}  // namespace

namespace dynfilter_test {

AllocationCount::AllocationCount() {
  counted_calls = 0, counted_bytes = 0;
  counting = true;
}
AllocationCount::~AllocationCount() {
  counting = false;
}
std::size_t AllocationCount::calls() const {
  return counted_calls;
}
std::size_t AllocationCount::bytes() const {
  return counted_bytes;
}
bool AllocationCount::works() {
  return DYNFILTER_OWN_ALLOCATOR != 0;
}

}  // namespace dynfilter_test

#if DYNFILTER_OWN_ALLOCATOR
// The names are those of the GNU C library.
extern "C" {
void* __libc_malloc(std::size_t);                 // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t, std::size_t);    // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void*, std::size_t);         // NOLINT(bugprone-reserved-identifier)
void* __libc_memalign(std::size_t, std::size_t);  // NOLINT(bugprone-reserved-identifier)

void* malloc(std::size_t bytes) noexcept {
  count(bytes);
  return __libc_malloc(bytes);
}
void* calloc(std::size_t n, std::size_t bytes) noexcept {
  count(n * bytes);
  return __libc_calloc(n, bytes);
}
void* realloc(void* old, std::size_t bytes) noexcept {
  count(bytes);
  return __libc_realloc(old, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  count(bytes);
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  count(bytes);
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** to, std::size_t alignment, std::size_t bytes) noexcept {
  count(bytes);
  *to = __libc_memalign(alignment, bytes);
  return *to == nullptr ? ENOMEM : 0;
}
}
#endif
