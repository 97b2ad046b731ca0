// SPDX-License-Identifier: Apache-2.0
// Writes the keys of a cell that has none over the serial line to which it is alone connected.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "serial/unit_side.hpp"

namespace robotskin::serial {

// Writes the keys of the cell at `path`, derived from the secret of the skin's section units; its serial number.
// Throws SerialError: no such line, no cell there, one that has keys already, another one than `expected`, firmware of
// another version, or no word that the keys are kept.
std::uint32_t commission(const std::string& path, const CellKey& secret, std::optional<std::uint32_t> expected,
                         std::chrono::milliseconds within);

}  // namespace robotskin::serial
