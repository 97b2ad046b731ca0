// SPDX-License-Identifier: Apache-2.0
// Datagrams without a network: they wait in order until they are taken.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "world/network/transport.hpp"

namespace robotskin::world {

// If they are not taken, the oldest give way and are counted.
class InProcess : public Transport {
 public:
  static constexpr std::size_t waiting_max = 65536;

  struct Waiting {
    std::size_t unit;
    std::int64_t time_ns;  // virtual
    std::vector<std::uint8_t> datagram;
  };

  void send(std::size_t unit, std::int64_t time_ns, std::span<const std::uint8_t> datagram) override;
  void deliver(Network& network) override;

  void post(std::size_t unit, std::span<const std::uint8_t> datagram);  // from the host
  std::vector<Waiting> take();                                          // to the host, in the order sent
  std::uint64_t overflowed() const { return overflowed_; }

 private:
  std::deque<Waiting> up_;
  std::vector<Waiting> down_;
  std::uint64_t overflowed_ = 0;
};

}  // namespace robotskin::world
