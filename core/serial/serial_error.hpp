// SPDX-License-Identifier: Apache-2.0
// A serial line that is not there, or is not fit for cells.
#pragma once

#include <stdexcept>

namespace robotskin::serial {

// The message names the line, what was found and what was expected.
class SerialError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace robotskin::serial
