// SPDX-License-Identifier: Apache-2.0
// Bytes between Python and the firmware's plain arrays.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace robotskin::bindings {

inline nanobind::bytes as_bytes(const std::uint8_t* data, std::size_t count) {
  return nanobind::bytes(reinterpret_cast<const char*>(data), count);
}

// The bytes, after a check of their number.
inline const std::uint8_t* exactly(const nanobind::bytes& bytes, std::size_t count, const char* what) {
  if (bytes.size() != count) {
    throw nanobind::value_error(
        (std::string(what) + " has " + std::to_string(count) + " bytes, not " + std::to_string(bytes.size())).c_str());
  }
  return static_cast<const std::uint8_t*>(bytes.data());
}

}  // namespace robotskin::bindings
