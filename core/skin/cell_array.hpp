// SPDX-License-Identifier: Apache-2.0
// An array with an entry a cell that begins at a cache line, so that wide loads from it do not cross one.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace robotskin::skin {

template <typename Value>
struct CacheLineAllocator {
  using value_type = Value;
  static constexpr std::align_val_t line{64};

  CacheLineAllocator() = default;
  template <typename Other>
  CacheLineAllocator(const CacheLineAllocator<Other>&) noexcept {}

  Value* allocate(std::size_t count) { return static_cast<Value*>(::operator new(count * sizeof(Value), line)); }
  void deallocate(Value* values, std::size_t) noexcept { ::operator delete(values, line); }
  bool operator==(const CacheLineAllocator&) const = default;
};

template <typename Value>
using CellArray = std::vector<Value, CacheLineAllocator<Value>>;

}  // namespace robotskin::skin
