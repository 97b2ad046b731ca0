// SPDX-License-Identifier: Apache-2.0
// Counts every heap allocation of a test program, those inside shared libraries too. Include in one source only.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>

// The names under which glibc offers its own functions to those who replace them.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

inline std::atomic<long> allocation_count{0};

extern "C" {
void* malloc(std::size_t size) {
  ++allocation_count;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocation_count;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocation_count;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocation_count;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++allocation_count;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? 12 : 0;
}
}

// Allocations made by calling something.
template <typename Call>
long allocations_of(Call&& call) {
  const long before = allocation_count;
  call();
  return allocation_count - before;
}
