// SPDX-License-Identifier: Apache-2.0
// What the cell network says about its own shape.
#pragma once

#include <array>
#include <cstdint>

#include "robotskin/wire.h"

namespace robotskin::driver {

struct ReportedNeighbour {
  std::uint16_t id = RS_ID_NONE;  // 16383: a section unit
  std::uint8_t port = 0;          // the port it uses, 1 to 4
  std::uint8_t errors = 0;        // binary digits of the count of frames lost there, at most 7
};

// The newest topology frame of one cell.
struct TopologyRow {
  std::int64_t heard_ns = 0;  // host clock; 0: never
  std::uint32_t uid = 0;      // serial number
  std::uint8_t revision = 0;
  std::uint8_t parent_port = 0;  // 1 to 4, 0: none
  std::uint8_t closed_port = 0;  // by wrong tags, now or lately, 0: none; 5: orders under its own key are not read
  std::array<ReportedNeighbour, RS_PORTS> neighbours{};
};

// One port of one section unit.
struct UnitPortRow {
  std::int64_t heard_ns = 0;
  std::uint16_t cell = RS_ID_NONE;  // what is plugged in
  std::uint8_t cell_port = 0;
  std::uint16_t size = 0;         // cells of the tree below
  std::uint8_t height = 0;        // hops to its deepest cell
  std::uint8_t rate_divisor = 1;  // its cells send every n-th sample
};

// One section unit.
struct UnitRow {
  std::int64_t heard_ns = 0;  // host clock; 0: this row is not used
  std::int64_t clock_offset_ns = 0;
  std::uint64_t datagrams = 0, datagrams_lost = 0;
  std::uint32_t frames_dropped = 0;
  std::uint32_t session = 0;
  std::uint16_t group = 0;
  std::uint8_t unit = 0;
  std::uint8_t version = 0;             // of its firmware; 0: not told
  std::array<UnitPortRow, 16> ports{};  // by port number; 0 is not used
};

inline TopologyRow topology_row(const rs_topology& frame, std::int64_t heard_ns) {
  TopologyRow row;
  row.heard_ns = heard_ns;
  row.uid = frame.uid;
  row.revision = static_cast<std::uint8_t>(frame.revision);
  row.parent_port = static_cast<std::uint8_t>(frame.parent_port);
  row.closed_port = static_cast<std::uint8_t>(frame.closed);
  const std::uint32_t ids[] = {frame.neighbour_1, frame.neighbour_2, frame.neighbour_3, frame.neighbour_4};
  const std::uint32_t ports[] = {frame.neighbour_port_1, frame.neighbour_port_2, frame.neighbour_port_3,
                                 frame.neighbour_port_4};
  const std::uint32_t errors[] = {frame.errors_1, frame.errors_2, frame.errors_3, frame.errors_4};
  for (unsigned i = 0; i < RS_PORTS; ++i) {
    row.neighbours[i] = {static_cast<std::uint16_t>(ids[i]), static_cast<std::uint8_t>(ids[i] != 0 ? ports[i] + 1 : 0),
                         static_cast<std::uint8_t>(errors[i])};
  }
  return row;
}

}  // namespace robotskin::driver
