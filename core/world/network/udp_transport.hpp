// SPDX-License-Identifier: Apache-2.0
// Datagrams over real UDP: each section unit has its own socket, as the boxes on a robot have.
//
// A unit answers the host that last sent it a datagram that its firmware took; before, it sends to `host`, if one is
// given.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driver/udp_socket.hpp"
#include "world/network/transport.hpp"

namespace robotskin::world {

class UdpTransport : public Transport {
 public:
  // Binds one socket a unit at consecutive ports from `first_port` on, or at any free ones if that is 0.
  // Throws std::system_error if a port is taken, std::invalid_argument for an unknown host.
  UdpTransport(std::size_t units, const std::string& bind, std::uint16_t first_port,
               const std::optional<driver::Address>& host);

  UdpTransport(const UdpTransport&) = delete;
  UdpTransport& operator=(const UdpTransport&) = delete;

  void send(std::size_t unit, std::int64_t time_ns, std::span<const std::uint8_t> datagram) override;
  void deliver(Network& network) override;

  driver::Address address(std::size_t unit) const { return ends_.at(unit).socket->local(); }
  std::size_t unit_count() const { return ends_.size(); }
  std::uint64_t sent() const { return sent_; }          // datagrams handed to the system
  std::uint64_t unsent() const { return unsent_; }      // datagrams without a host, or that the system did not take
  std::uint64_t received() const { return received_; }  // datagrams from the host

 private:
  struct End {
    std::unique_ptr<driver::UdpSocket> socket;
    std::optional<driver::Address> host;
  };

  std::vector<End> ends_;
  std::uint64_t sent_ = 0, unsent_ = 0, received_ = 0;
};

}  // namespace robotskin::world
