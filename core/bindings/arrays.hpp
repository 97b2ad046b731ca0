// SPDX-License-Identifier: Apache-2.0
// Arrays between numpy and plain vectors. Results come as copies, because a view would change with the next cycle.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <initializer_list>
#include <span>
#include <stdexcept>

namespace robotskin::bindings {

template <typename Value>
using InputArray = nanobind::ndarray<const Value, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;

template <typename Value>
std::span<const Value> span_of(const InputArray<Value>& array) {
  return {array.data(), array.shape(0)};
}

template <typename Value>
nanobind::ndarray<nanobind::numpy, Value> copy_of(std::span<const Value> values,
                                                  std::initializer_list<std::size_t> shape) {
  auto* data = new Value[values.empty() ? 1 : values.size()];
  std::ranges::copy(values, data);
  nanobind::capsule owner(data, [](void* memory) noexcept { delete[] static_cast<Value*>(memory); });
  return nanobind::ndarray<nanobind::numpy, Value>(data, shape.size(), shape.begin(), owner);
}

template <typename Value>
nanobind::ndarray<nanobind::numpy, Value> copy_of(std::span<const Value> values) {
  return copy_of(values, {values.size()});
}

}  // namespace robotskin::bindings
