// SPDX-License-Identifier: Apache-2.0
// A section unit and host-built cells with lines between them, in virtual time: what daemon and cells do, without a
// machine that stalls.
#pragma once

#include <functional>
#include <vector>

#include "serial/cell_side.hpp"
#include "serial/unit_side.hpp"

namespace robotskin::serial {

class VirtualSkin : private UnitSide::Outward, private CellSide::Outward {
 public:
  using Take = std::function<void(std::span<const std::uint8_t>, std::int64_t now_ns)>;

  // Line k leads to port k + 1 of the section unit. `datagrams` takes what is for the host.
  VirtualSkin(const UnitOptions& unit, std::vector<HostCell> cells, CellSensors& sensors, std::int64_t epoch_ns,
              Take datagrams);

  void run_until(std::int64_t now_ns);
  void receive(std::span<const std::uint8_t> datagram) { unit_.datagram(datagram, now_ns_); }
  // A line that is pulled carries nothing.
  void pull(std::size_t line, bool pulled);

  const UnitSide& unit() const { return unit_; }
  const CellSide& cells() const { return cells_; }

 private:
  struct InFlight {
    std::int64_t due_ns;
    std::size_t line;
    bool up;
    std::array<std::uint8_t, RS_FRAME_BYTES> frame;
  };

  void frame(unsigned port, FrameBytes frame, std::int64_t now_ns) override { put(port - 1, false, frame, now_ns); }
  void datagram(std::span<const std::uint8_t> datagram, bool to_peers) override {
    if (!to_peers) datagrams_(datagram, now_ns_);
  }
  void frame(std::size_t line, FrameBytes frame, std::int64_t now_ns) override { put(line, true, frame, now_ns); }
  void put(std::size_t line, bool up, FrameBytes frame, std::int64_t now_ns);

  std::int64_t now_ns_;
  Take datagrams_;
  std::vector<InFlight> in_flight_;
  std::vector<bool> pulled_;
  UnitSide unit_;
  CellSide cells_;
};

}  // namespace robotskin::serial
