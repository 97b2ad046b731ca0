// SPDX-License-Identifier: Apache-2.0
#include "world/network/udp_transport.hpp"

namespace robotskin::world {
namespace {

constexpr int buffer_bytes = 1 << 20;

}  // namespace

UdpTransport::UdpTransport(std::size_t units, const std::string& bind, std::uint16_t first_port,
                           const std::optional<driver::Address>& host) {
  for (std::size_t u = 0; u < units; ++u) {
    const auto port = static_cast<std::uint16_t>(first_port == 0 ? 0 : first_port + u);
    const auto local = driver::Address::resolve(bind, port, host ? host->storage.ss_family : AF_UNSPEC);
    ends_.push_back({std::make_unique<driver::UdpSocket>(local, buffer_bytes), host});
  }
}

void UdpTransport::send(std::size_t unit, std::int64_t, std::span<const std::uint8_t> datagram) {
  const End& end = ends_[unit];
  ++(end.host && end.socket->send(datagram, *end.host) ? sent_ : unsent_);
}

void UdpTransport::deliver(Network& network) {
  for (std::size_t u = 0; u < ends_.size(); ++u) {
    driver::UdpSocket& socket = *ends_[u].socket;
    for (std::size_t count = driver::UdpSocket::batch; count == driver::UdpSocket::batch;) {
      count = socket.receive();
      for (std::size_t i = 0; i < count; ++i) {
        ++received_;
        const std::uint32_t refused = network.unit(u).refused;
        const std::optional<driver::Address> before = ends_[u].host;
        ends_[u].host = socket.sender(i);  // the answer may leave at once
        network.receive(u, socket.datagram(i));
        if (network.unit(u).refused != refused) ends_[u].host = before;
      }
    }
  }
}

}  // namespace robotskin::world
