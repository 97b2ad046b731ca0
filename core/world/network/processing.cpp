// SPDX-License-Identifier: Apache-2.0
// Cells whose processor takes time: their boards hold what comes and what goes until the processor, or the line, is
// free. The main loop is that of firmware/chip/main.c.
#include <algorithm>
#include <bit>
#include <cstring>

#include "robotskin/timing.h"
#include "world/network/parts.hpp"

namespace robotskin::world {
namespace {

// As of firmware/chip/board.h.
enum : std::uint32_t { line_event = 1U << 0, sent_event = 1U << 4, timer_event = 1U << 8, sample_event = 1U << 9 };

}  // namespace

bool Network::idle(std::size_t index) const {
  return cells_[index].free_ns <= lane_of_cell(index).now_ns && boards_[index].events == 0 && boards_[index].in.empty();
}

// ---- Frames that have come ----

std::uint32_t Network::Board::Blocks::ports() const {
  std::uint32_t ports = 0;
  for (std::size_t at = 0; at < count_; ++at) ports |= 1U << port_[at];
  return ports;
}

Network::Board::Frame& Network::Board::Blocks::push(std::size_t port) {
  port_[count_] = static_cast<std::uint8_t>(port);
  return frame_[count_++];
}

Network::Board::Frame Network::Board::Blocks::pop(std::size_t port) {
  const auto at = std::find(port_.begin(), port_.begin() + count_, port) - port_.begin();
  const Frame frame = frame_[static_cast<std::size_t>(at)];
  std::copy(frame_.begin() + at + 1, frame_.begin() + count_, frame_.begin() + at);
  std::copy(port_.begin() + at + 1, port_.begin() + count_, port_.begin() + at);
  --count_;
  return frame;
}

// ---- Lines ----

// What the subtree sends to the host leaves room for what keeps the tree together, and for orders.
bool Network::has_room(std::size_t wire, const std::uint8_t* frame) const {
  if (!takes_time()) return true;
  const rs_frame_type type = rs_frame_type_of(frame);
  const bool to_host = type == RS_TYPE_clock || type == RS_TYPE_event || type == RS_TYPE_further ||
                       type == RS_TYPE_topology || type == RS_TYPE_join || type == RS_TYPE_reply ||
                       type == RS_TYPE_torque;
  return boards_[wire / RS_PORTS].in.count() < board_frames_in - (to_host ? board_frames_kept : 0);
}

void Network::arrive(std::size_t wire, const std::uint8_t* frame) {
  const std::size_t index = wire / RS_PORTS, port = wire % RS_PORTS;
  if (takes_time() && !idle(index)) {
    Board::Frame& place = boards_[index].in.push(port);
    place.time_ns = lane_of_cell(index).now_ns;
    std::memcpy(place.bytes.data(), frame, RS_FRAME_BYTES);
    return plan(index);
  }
  rs_input input{};
  input.kind = RS_INPUT_FRAME;
  input.port = static_cast<std::uint8_t>(port + 1);
  input.frame = frame;
  step_cell(index, input);
}

bool Network::takes_frame(std::size_t wire) const {
  return takes_time() ? !boards_[wire / RS_PORTS].out[wire % RS_PORTS].full() : wires_[wire].end_ns == never;
}

void Network::send(std::size_t wire, const std::uint8_t* frame) {
  if (!takes_time()) return start(static_cast<std::uint32_t>(wire), frame, lane_of_wire(wire).now_ns);
  Cell& cell = cells_[wire / RS_PORTS];
  auto& ring = boards_[wire / RS_PORTS].out[wire % RS_PORTS];
  if (ring.full()) return;  // damaged memory may forget that: the board knows, and takes none
  Board::Frame& place = ring.push();
  place.time_ns = cell.free_ns;
  std::memcpy(place.bytes.data(), frame, RS_FRAME_BYTES);
  if (ring.count == 1) start(static_cast<std::uint32_t>(wire), place.bytes.data(), cell.free_ns);
  if (!ring.full()) cell.sent |= static_cast<std::uint8_t>(1U << wire % RS_PORTS);
}

// The frame on the wire has ended.
void Network::let_go(std::size_t wire) {
  bool told = false;
  if (takes_time()) {
    auto& ring = boards_[wire / RS_PORTS].out[wire % RS_PORTS];
    told = !ring.full();
    if (ring.count > 0) ring.pop();
    if (ring.count > 0)
      start(static_cast<std::uint32_t>(wire), ring.front().bytes.data(),
            std::max(lane_of_wire(wire).now_ns, ring.front().time_ns));
  }
  const std::size_t index = wire / RS_PORTS;
  Cell& cell = cells_[index];
  if (cell.power != Cell::Power::on || told) return;
  const auto bit = static_cast<std::uint8_t>(1U << wire % RS_PORTS);
  const bool waited_for = (cell.waiting & bit) != 0;
  if (!waited_for || (takes_time() && !idle(index))) {
    cell.sent |= bit;
    if (waited_for) plan(index);
    return;
  }
  rs_input input{};
  input.kind = RS_INPUT_SENT;
  input.port = static_cast<std::uint8_t>(wire % RS_PORTS + 1);
  step_cell(index, input);
}

// ---- The main loop ----

void Network::plan(std::size_t index) {
  Cell& cell = cells_[index];
  Lane& lane = lane_of_cell(index);
  const Board& board = boards_[index];
  const bool waits =
      cell.power == Cell::Power::on && (board.events != 0 || !board.in.empty() || (cell.sent & cell.waiting) != 0);
  if (!waits && cell.due_ns == never) return;
  const std::int64_t time_ns = std::max(waits ? lane.now_ns : cell.due_ns, cell.free_ns);
  if (time_ns < cell.scheduled_ns) lane.queue.push(cell.scheduled_ns = time_ns, static_cast<std::uint32_t>(index));
}

std::uint32_t Network::events_of(std::size_t index) const {
  const Cell& cell = cells_[index];
  const std::int64_t now_ns = lane_of_cell(index).now_ns;
  const Board& board = boards_[index];
  std::uint32_t events = (cell.sent & cell.waiting) != 0 ? sent_event : 0;
  events |= board.in.ports() * line_event;
  if (cell.due_ns > now_ns) return events;
  const bool samples = cell.sampling && static_cast<std::int32_t>(cell.clock_us(now_ns) - cell.sample_us) >= 0;
  return events | (samples ? sample_event : timer_event);
}

void Network::serve(std::size_t index) {
  Cell& cell = cells_[index];
  const std::int64_t now_ns = lane_of_cell(index).now_ns;
  Board& board = boards_[index];
  if (cell.free_ns > now_ns) return plan(index);
  if (board.events == 0) board.events = events_of(index);
  // What has been told meanwhile is no event any more.
  if ((cell.sent & cell.waiting) == 0) board.events &= ~sent_event;
  if (board.events == 0) return plan(index);

  const std::uint32_t event = board.events & (~board.events + 1U);
  board.events ^= event;
  rs_input input{};
  if (event < sent_event) {
    const auto port = static_cast<std::size_t>(std::countr_zero(event));
    const Board::Frame frame = board.in.pop(port);
    input.kind = RS_INPUT_FRAME;
    input.port = static_cast<std::uint8_t>(port + 1);
    input.frame = frame.bytes.data();
    input.late_us = static_cast<std::uint16_t>(
        std::min(static_cast<double>(now_ns - frame.time_ns) * cell.us_per_ns, double{UINT16_MAX}));
    return step_cell(index, input);
  }
  if (event == sent_event) {
    input.kind = RS_INPUT_SENT;
    input.port = static_cast<std::uint8_t>(std::countr_zero(cell.sent) + 1);
  } else if (event == sample_event) {
    input.kind = RS_INPUT_SAMPLE;
    input.fault = source_.sample(index, now_ns, cell.sample);
    input.sample = &cell.sample;
  } else {
    input.kind = RS_INPUT_TIMER;
  }
  step_cell(index, input);
}

void Network::forget_board(std::size_t index) {
  if (!takes_time()) return;
  cells_[index].free_ns = 0;
  cells_[index].sent = 0;
  boards_[index] = {};
}

}  // namespace robotskin::world
