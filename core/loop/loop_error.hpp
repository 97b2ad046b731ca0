// SPDX-License-Identifier: Apache-2.0
// Parts of a loop that do not fit together.
#pragma once

#include <stdexcept>

namespace robotskin::loop {

class LoopError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace robotskin::loop
