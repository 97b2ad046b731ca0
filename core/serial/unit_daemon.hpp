// SPDX-License-Identifier: Apache-2.0
// The section unit on a Linux machine: its firmware between serial lines and a UDP socket, in real time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driver/udp_socket.hpp"
#include "serial/frame_line.hpp"
#include "serial/real_time.hpp"
#include "serial/unit_side.hpp"

namespace robotskin::serial {

struct UnitReport {
  std::vector<LineCounts> lines;
  std::uint64_t datagrams_out = 0, datagrams_in = 0;
  std::uint64_t unheard = 0;         // datagrams for which no host was known yet, or that the system did not take
  std::uint32_t refused = 0;         // datagrams from outside
  std::uint64_t other_versions = 0;  // datagrams of another version, each answered with the own one
  std::uint32_t named = 0;           // cells
  Stalls stalls;
};

class UnitDaemon : public RealTime, private UnitSide::Outward {
 public:
  // Line k is port k + 1. Binds `host` and `port` (0: any free one); `peers` are the group's other units.
  // Throws SerialError for a line that is not fit, std::system_error for a port that is taken.
  UnitDaemon(UnitOptions options, const std::vector<std::string>& lines, const std::string& host, std::uint16_t port,
             const std::vector<driver::Address>& peers, const std::string& sysfs);
  ~UnitDaemon() override { stop(); }

  driver::Address address() const { return socket_.local(); }
  UnitReport report() const;

 protected:
  std::int64_t turn(std::int64_t now_ns) override;
  void wait_for(std::vector<pollfd>& descriptors) const override;

 private:
  void frame(unsigned port, FrameBytes frame, std::int64_t) override { lines_[port - 1].send(frame); }
  void datagram(std::span<const std::uint8_t> datagram, bool to_peers) override;
  void take_datagrams(std::int64_t now_ns);

  std::vector<FrameLine> lines_;
  driver::UdpSocket socket_;
  std::vector<driver::Address> peers_;
  std::optional<driver::Address> host_;
  UnitReport counts_;
  UnitSide unit_;
};

}  // namespace robotskin::serial
