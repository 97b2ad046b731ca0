// SPDX-License-Identifier: Apache-2.0
// Bytes and tables between Python and the driver.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>

#include "driver/keyed_hash.hpp"

namespace robotskin::bindings {

inline std::span<const std::uint8_t> bytes_of(const nanobind::bytes& bytes) {
  return {static_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

// Throws std::invalid_argument for a wrong length.
inline driver::Key key_from(const nanobind::bytes& bytes) {
  driver::Key key;
  if (bytes.size() != key.size()) {
    throw std::invalid_argument("the key has " + std::to_string(bytes.size()) + " bytes instead of " +
                                std::to_string(key.size()));
  }
  std::copy_n(bytes_of(bytes).data(), key.size(), key.begin());
  return key;
}

// Raises robotskin.errors.InputError for what the function refuses: std::invalid_argument, std::system_error.
template <class Function>
auto with_input_errors(const Function& function) {
  const auto raise = [](const std::exception& refused) {
    const nanobind::object type = nanobind::module_::import_("robotskin.errors").attr("InputError");
    PyErr_SetString(type.ptr(), refused.what());
    throw nanobind::python_error();
  };
  try {
    return function();
  } catch (const std::invalid_argument& refused) {
    raise(refused);
  } catch (const std::system_error& refused) {
    raise(refused);
  }
  return decltype(function())();
}

// A new numpy array (rows, columns), or (rows) for one column, filled by `value(row, column)`.
template <class Value, class Function>
nanobind::object filled(std::size_t rows, std::size_t columns, const Function& value) {
  namespace nb = nanobind;
  auto* data = new Value[rows * columns + 1];
  const nb::capsule owner(data, [](void* pointer) noexcept { delete[] static_cast<Value*>(pointer); });
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) data[row * columns + column] = value(row, column);
  }
  if (columns == 1) return nb::cast(nb::ndarray<nb::numpy, Value, nb::ndim<1>>(data, {rows}, owner));
  return nb::cast(nb::ndarray<nb::numpy, Value, nb::ndim<2>>(data, {rows, columns}, owner));
}

}  // namespace robotskin::bindings
