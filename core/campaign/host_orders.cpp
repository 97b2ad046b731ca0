#include "campaign/host_orders.hpp"

#include <array>

#include "robotskin/datagram.h"
#include "robotskin/operations.h"
#include "world/random.hpp"

namespace robotskin::campaign {
namespace {

constexpr std::uint32_t number_bits = 10;  // of a colour's 24; the others prove it

void add_record(std::vector<std::uint8_t>& datagram, const std::array<std::uint8_t, RS_FRAME_BYTES>& frame) {
  datagram.insert(datagram.end(), frame.begin(), frame.begin() + RS_CONTENT_BYTES);
  datagram.insert(datagram.end(), {0, 0});  // to all ports
}

}  // namespace

std::uint32_t HostOrders::colour_of(std::uint32_t order) const {
  const auto proof = static_cast<std::uint32_t>(world::scramble(seed_ ^ order)) & 0x3FFFU;
  return proof << number_bits | (order & ((1U << number_bits) - 1U));
}

void HostOrders::send(world::Network& network) {
  const std::int64_t now_ms = network.time_ns() / ms;
  if (!in_use_ || now_ms % joints_every_ms != 0) return;
  std::vector<std::uint8_t> datagram(RS_DATAGRAM_HEADER_BYTES);
  std::array<std::uint8_t, RS_FRAME_BYTES> frame;
  rs_joints joints{};
  joints.type = RS_TYPE_joints;
  joints.joint_1 = static_cast<std::int16_t>(now_ms);
  rs_joints_pack(frame.data(), &joints);
  add_record(datagram, frame);
  if (now_ms % orders_every_ms == 0) {
    rs_command command{};
    command.type = RS_TYPE_command;
    command.target = RS_ID_ALL;
    command.operation = RS_OPERATION_led;
    command.counter = ++orders_ & 0xFFFFU;
    command.value_low = colour_of(orders_);
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

void HostOrders::poll(const world::Network& network) {
  if (!in_use_) return;
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) {
    const std::uint32_t colour = network.cell(cell).led_rgb, order = colour & ((1U << number_bits) - 1U);
    if (colour == 0 || (order <= orders_ && colour == colour_of(order))) continue;
    breaks_.add(Invariant::forged, network.time_ns(), {cell}, {{"colour", colour}, {"orders", orders_}});
  }
}

}  // namespace robotskin::campaign
