// SPDX-License-Identifier: Apache-2.0
// A controller that is not there, is not the one that was asked for, or cannot do what is needed.
#pragma once

#include <stdexcept>

namespace robotskin::ur {

// The message names the address, what was found and what was expected.
class UrError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace robotskin::ur
