// SPDX-License-Identifier: Apache-2.0
// How datagrams travel between section units and host.
#pragma once

#include "world/network/network.hpp"

namespace robotskin::world {

class Transport : public DatagramSink {
 public:
  // Gives everything the host has sent to `network` at its present time.
  virtual void deliver(Network& network) = 0;
};

}  // namespace robotskin::world
