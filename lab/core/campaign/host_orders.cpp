// SPDX-License-Identifier: Apache-2.0
#include "campaign/host_orders.hpp"

#include <algorithm>
#include <array>

#include "campaign/touch_checker.hpp"
#include "robotskin/datagram.h"
#include "robotskin/operations.h"
#include "world/random.hpp"

namespace robotskin::campaign {
namespace {

constexpr std::int64_t way_ns = 20 * ms;   // down to the deepest cell, behind other orders
constexpr std::uint32_t number_bits = 10;  // of a colour's 24; the others prove it
constexpr std::uint32_t number_mask = (1U << number_bits) - 1U;

void add_record(std::vector<std::uint8_t>& datagram, const std::array<std::uint8_t, RS_FRAME_BYTES>& frame) {
  datagram.insert(datagram.end(), frame.begin(), frame.begin() + RS_CONTENT_BYTES);
  datagram.insert(datagram.end(), {0, 0});  // to all ports
}

}  // namespace

std::uint32_t HostOrders::colour_of(std::uint32_t order) const {
  const auto proof = static_cast<std::uint32_t>(world::scramble(seed_ ^ order)) & 0x3FFFU;
  return proof << number_bits | (order & number_mask);
}

void HostOrders::send(world::Network& network) {
  const std::int64_t now_ms = network.time_ns() / ms;
  if (!in_use_ || now_ms % joints_every_ms != 0) return;
  std::vector<std::uint8_t> datagram(RS_DATAGRAM_HEADER_BYTES);
  std::array<std::uint8_t, RS_FRAME_BYTES> frame;
  rs_joints joints{};
  joints.type = RS_TYPE_joints;
  joints.joint_1 = static_cast<std::int16_t>(now_ms);
  if (postures_) {
    const auto posture = posture_at(seed_, now_ms);
    joints.joint_2 = posture[1];
    joints.joint_3 = posture[2];
    joints.joint_4 = posture[3];
    joints.joint_5 = posture[4];
    joints.joint_6 = posture[5];
  }
  rs_joints_pack(frame.data(), &joints);
  add_record(datagram, frame);
  if (now_ms % orders_every_ms == 0) {
    rs_command command{};
    command.type = RS_TYPE_command;
    command.target = RS_ID_ALL;
    command.operation = RS_OPERATION_led;
    sent_ns_.push_back(network.time_ns());
    for (std::uint32_t& orders_missed : passed_by_) orders_missed <<= 1U;
    command.counter = orders() & 0xFFFFU;
    command.value_low = colour_of(orders());
    rs_command_pack(frame.data(), &command);
    add_record(datagram, frame);
  }
  rs_datagram_header header{};
  header.kind = RS_DATAGRAM_KIND_inject;
  header.unit = RS_UNIT_ALL;
  header.session = 1;
  header.sequence = ++datagrams_;
  header.time_ns = static_cast<std::uint64_t>(network.time_ns());
  header.count = static_cast<std::uint16_t>((datagram.size() - RS_DATAGRAM_HEADER_BYTES) / RS_DATAGRAM_RECORD_BYTES);
  rs_datagram_header_pack(datagram.data(), &header);
  for (std::size_t unit = 0; unit < network.unit_count(); ++unit) network.receive(unit, datagram);
}

void HostOrders::note_moves(const world::Network& network, const RouteChecker& routes) {
  const std::int64_t now_ns = network.time_ns();
  parent_port_.resize(network.cell_count());
  passed_by_.resize(network.cell_count());
  std::uint32_t under_way = 0;
  for (std::size_t back = 0; back < sent_ns_.size() && sent_ns_[sent_ns_.size() - 1 - back] >= now_ns - way_ns; ++back)
    under_way |= 1U << back;
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) {
    const auto port = static_cast<std::uint8_t>(routes.parent_port(cell));
    if (port != parent_port_[cell]) passed_by_[cell] |= under_way;
    parent_port_[cell] = port;
  }
}

void HostOrders::poll(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                      const RecoveryChecker& recovery) {
  if (!in_use_) return;
  const std::int64_t now_ns = network.time_ns();
  told_.resize(network.cell_count());
  note_moves(network, routes);
  // The newest order that all have by now, or one of the two after it: one may pass by a cell that moves. A cell that
  // goes to and fro as often as orders come may miss all three.
  const auto past = std::ranges::upper_bound(sent_ns_, now_ns - 2 * orders_every_ms * ms - way_ns);
  const auto known = static_cast<std::uint32_t>(past - sent_ns_.begin());
  const bool judged = known > 0;
  // Where cells ask for ids the answers come by the same way, and there are more of them than can wait.
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell)
    if (recovery.has_path(cell) && network.cell(cell).id == RS_ID_NONE)
      naming_ns_[network.cell(cell).route.wave.root] = now_ns;
  naming_beside_ns_.resize(network.cell_count());
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell)
    naming_beside_ns_[cell] = std::max(naming_beside_ns_[cell], naming_ns_[network.cell(cell).route.wave.root]);
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) {
    // The newest one so far whose number has these bits.
    const std::uint32_t colour = network.cell(cell).led_rgb;
    const std::uint32_t order = orders() - ((orders() - colour) & number_mask);
    const bool lawless = ground.lawless(now_ns, cell);  // its colour may have been overwritten
    if (!lawless && colour != 0 && (order > orders() || colour != colour_of(order)))
      breaks_.add(Invariant::forged, now_ns, {cell}, {{"colour", colour}, {"orders", orders()}});
    if (!judged || !recovery.calm(cell, now_ns) || order >= known || told_[cell] != 0 || !recovery.has_path(cell))
      continue;
    const std::int64_t able_ns = std::max(
        {recovery.repaired_ns(cell), naming_beside_ns_[cell], recovery.path_since_ns(cell), ground.booted_ns(cell)});
    if (able_ns + ms > sent_ns_[known - 1]) continue;
    constexpr std::uint32_t three = 7;
    if ((passed_by_[cell] >> (orders() - known - 2) & three) == three) continue;
    told_[cell] = 1;
    if (!losses_.whole()) {
      losses_.add(1);
      continue;
    }
    breaks_.add(Invariant::obeyed, now_ns, {cell}, {{"order", order}, {"sent before", known}, {"orders", orders()}});
  }
}

void HostOrders::finish(const world::Network& network) {
  if (!in_use_) return;
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) losses_.due(network.cell(cell).route.hops);
  if (losses_.too_many())
    breaks_.add(Invariant::obeyed, network.time_ns(), {},
                {{"cells that missed orders on lossy lines", losses_.lost()}, {"at most", losses_.at_most()}});
}

}  // namespace robotskin::campaign
