// SPDX-License-Identifier: Apache-2.0
// A case as text that can be kept: all of it, and not only the seed it was once drawn from.
//
// A line a part, each a word and its values; a cell is its four wires, `12.3` for port 3 of cell 12 and `-` for none,
// then the id in its flash if it has one.
#pragma once

#include <string>
#include <string_view>

#include "campaign/fault_case.hpp"

namespace robotskin::campaign {

std::string text_of(const FaultCase& drawn);

// Throws std::invalid_argument, which names the line that cannot be read, and FaultError.
FaultCase case_of(std::string_view text);

}  // namespace robotskin::campaign
