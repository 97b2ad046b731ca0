// SPDX-License-Identifier: Apache-2.0
#include "serial/unit_daemon.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "robotskin/datagram.h"
#include "serial/serial_line.hpp"

namespace robotskin::serial {
namespace {

constexpr int buffer_bytes = 1 << 20;

std::vector<FrameLine> opened(const std::vector<std::string>& paths, const std::string& sysfs) {
  std::vector<FrameLine> lines;
  for (const std::string& path : paths) lines.emplace_back(std::make_unique<SerialLine>(path, sysfs));
  return lines;
}

UnitOptions with_ports(UnitOptions options, std::size_t ports) {
  options.ports = static_cast<std::uint8_t>(ports);
  return options;
}

bool of_another_version(std::span<const std::uint8_t> datagram) {
  rs_datagram_header header;
  return rs_datagram_header_unpack(&header, datagram.data(), static_cast<std::uint32_t>(datagram.size())) ==
         RS_DATAGRAM_VERSION_ALIEN;
}

}  // namespace

UnitDaemon::UnitDaemon(UnitOptions options, const std::vector<std::string>& lines, const std::string& host,
                       std::uint16_t port, const std::vector<driver::Address>& peers, const std::string& sysfs)
    : lines_(opened(lines, sysfs)),
      socket_(driver::Address::resolve(host, port), buffer_bytes),
      peers_(peers),
      unit_(with_ports(options, lines.size()), *this, now_ns()) {}

void UnitDaemon::datagram(std::span<const std::uint8_t> datagram, bool to_peers) {
  if (to_peers) {
    for (const driver::Address& peer : peers_) (void)socket_.send(datagram, peer);
    return;
  }
  ++(host_ && socket_.send(datagram, *host_) ? counts_.datagrams_out : counts_.unheard);
}

void UnitDaemon::take_datagrams(std::int64_t now_ns) {
  const std::size_t count = socket_.receive();
  for (std::size_t i = 0; i < count; ++i) {
    ++counts_.datagrams_in;
    const driver::Address from = socket_.sender(i);
    if (of_another_version(socket_.datagram(i))) {
      ++counts_.other_versions;
      // Shorter than what it answers, so that it neither multiplies what is sent nor is answered itself.
      std::array<std::uint8_t, RS_DATAGRAM_VERSION_BYTES> told{};
      rs_datagram_version_pack(told.data());
      (void)socket_.send(told, from);
      continue;
    }
    const bool of_peer = std::ranges::any_of(peers_, [&](const driver::Address& peer) {
      return peer.length == from.length && std::memcmp(&peer.storage, &from.storage, from.length) == 0;
    });
    const std::optional<driver::Address> before = host_;
    if (!of_peer) host_ = from;  // the answer may leave at once
    if (!unit_.datagram(socket_.datagram(i), now_ns)) host_ = before;
  }
}

std::int64_t UnitDaemon::turn(std::int64_t now_ns) {
  take_datagrams(now_ns);
  for (std::size_t i = 0; i < lines_.size(); ++i)
    lines_[i].receive(now_ns,
                      [&](FrameBytes frame) { unit_.frame(static_cast<unsigned>(i + 1), frame, this->now_ns()); });
  return unit_.advance(this->now_ns());
}

void UnitDaemon::wait_for(std::vector<pollfd>& descriptors) const {
  descriptors.push_back({socket_.descriptor(), POLLIN, 0});
  for (const FrameLine& line : lines_)
    if (line.descriptor() >= 0) descriptors.push_back({line.descriptor(), POLLIN, 0});
}

UnitReport UnitDaemon::report() const {
  UnitReport found;
  {
    const std::lock_guard lock(working_);
    found = counts_;
    for (const FrameLine& line : lines_) found.lines.push_back(line.counts());
    found.refused = unit_.state().refused;
    found.named = unit_.state().ids.count;
  }
  found.stalls = stalls();
  return found;
}

}  // namespace robotskin::serial
