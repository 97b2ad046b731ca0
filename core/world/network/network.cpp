// SPDX-License-Identifier: Apache-2.0
// The network's clockwork: firmware stepped, frames carried, events in the order of their times.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "robotskin/crc.h"
#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {
namespace {

bool due(std::uint32_t now_us, std::uint32_t at_us) {
  return static_cast<std::int32_t>(now_us - at_us) >= 0;
}

}  // namespace

// ---- Stepping the firmware ----

void Network::boot(std::size_t index) {
  Cell& cell = cells_[index];
  cell.power = Cell::Power::on;
  Lane& lane = lane_of_cell(index);
  cell.booted_ns = lane.now_ns;
  cell.sent = 0;
  ++lane.topology_revision;
  rs_boot boot{};
  boot.uid = static_cast<std::uint32_t>(index) + 1;
  boot.random = static_cast<std::uint32_t>(random_bits(cell.boot_key, cell.boots++));
  boot.flash = cell.flash;
  std::array<std::uint8_t, RS_CELL_KEYS_BYTES> keys;
  if (cell_key() != nullptr) {
    rs_cell_keys(cell_key(), boot.uid, keys.data());
    boot.keys = keys.data();
  }
  boot.step_us = static_cast<std::uint16_t>(processing_ns(options_.processor, InputKind::wave, RS_PORTS) / 1000);
  rs_input input{};
  input.kind = RS_INPUT_BOOT;
  input.boot = &boot;
  step_cell(index, input);
  rs_cell_contribute(&cell.state, &cell.contribution);
}

void Network::step_cell(std::size_t index, rs_input input) {
  Cell& cell = cells_[index];
  Lane& lane = lane_of_cell(index);
  input.sent = std::exchange(cell.sent, std::uint8_t{0});
  rs_output output;
  const std::uint32_t now_us = cell.clock_us(lane.now_ns);
  const BeforeInput before(cell.state, now_us);
  rs_cell_step(&cell.state, &input, now_us, &output);
  if (external_ != nullptr && index == external_index_)
    external_->step(input, kind_of(input, before, cell.state), now_us, output);
  ++lane.counts.cell_steps;
  cell.sample_us = output.sample_us;
  cell.sampling = output.sampling;
  cell.waiting = output.waiting;
  if (takes_time()) {
    const auto frames = RS_PORTS - std::ranges::count(output.frame, nullptr);
    const std::int64_t taken_ns =
        processing_ns(options_.processor, kind_of(input, before, cell.state), static_cast<std::uint32_t>(frames));
    cell.free_ns = std::max(cell.free_ns, lane.now_ns) + taken_ns;
  }
  for (std::size_t p = 0; p < RS_PORTS; ++p)
    if (output.frame[p] != nullptr) send(RS_PORTS * index + p, output.frame[p]);
  if (output.flash_changed) std::memcpy(cell.flash, output.flash, RS_FLASH_BYTES);
  cell.queue_peak = std::max<std::uint32_t>(cell.queue_peak, rs_cell_waiting(&cell.state));
  auto delay_us = static_cast<std::int32_t>(output.timer_us - now_us);
  if (output.sampling) delay_us = std::min(delay_us, static_cast<std::int32_t>(output.sample_us - now_us));
  // A slow cell wakes so much later than it asked, however often frames make it step, and ask again, meanwhile.
  const auto delay_ns = static_cast<std::int64_t>(delay_us * cell.ns_per_us) + cell.slow_ns;
  wake_cell(index, lane.now_ns + std::max(delay_ns, static_cast<std::int64_t>(cell.ns_per_us)) + 1);
  tell([&](Observer& observer) { observer.cell_stepped(*this, index, input, output); });
  if (output.restart) reboot(index, restart_ns);
}

void Network::boot_unit(std::size_t index) {
  Unit& unit = units_[index];
  unit.stopped = false;
  const auto drawn = static_cast<std::uint32_t>(stream_key(options_.seed, purpose_session, index)) | 1U;
  unit.config.session = drawn + 2 * unit.starts++;
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_BOOT;
  input.config = &unit.config;
  step_unit(index, input);
}

void Network::step_unit(std::size_t index, const rs_unit_input& input) {
  Unit& unit = units_[index];
  Lane& lane = lane_of_unit(index);
  rs_unit_output output;
  rs_section_unit_step(unit.state.get(), &input, static_cast<std::uint64_t>(unit.clock_ns(lane.now_ns)), &output);
  const auto first_wire = static_cast<std::uint32_t>(cell_wires() + RS_SECTION_UNIT_PORTS_MAX * index);
  for (std::uint32_t p = 0; p < unit.config.ports; ++p)
    if (output.frame[p] != nullptr) start(first_wire + p, output.frame[p], lane.now_ns);
  if (output.datagram != nullptr && output.to_peers) {
    post_to_peers(index, {output.datagram, output.datagram_bytes});
  } else if (output.datagram != nullptr) {
    ++lane.counts.datagrams;
    lane.counts.datagram_bytes += output.datagram_bytes;
    rs_datagram_header header;
    if (rs_datagram_header_unpack(&header, output.datagram, output.datagram_bytes) == RS_DATAGRAM_OK &&
        header.kind == RS_DATAGRAM_KIND_frames)
      lane.counts.records += header.count;
    lane.log(static_cast<std::uint64_t>(lane.now_ns) ^ output.datagram_bytes);
    const std::span<const std::uint8_t> datagram(output.datagram, output.datagram_bytes);
    send_to_host(lane, index, datagram);
    tell([&](Observer& observer) { observer.datagram_to_host(*this, index, datagram); });
  }
  const auto timer_ns =
      static_cast<std::int64_t>(std::min<std::uint64_t>(output.timer_ns, static_cast<std::uint64_t>(never)));
  wake_unit(index, timer_ns == never ? never : std::max(unit.time_ns(timer_ns), lane.now_ns));
  if (output.power != unit.power) {
    unit.power = output.power;
    supply(lane);
  }
  tell([&](Observer& observer) { observer.unit_stepped(*this, index, input, output); });
}

void Network::wake_cell(std::size_t index, std::int64_t time_ns) {
  Cell& cell = cells_[index];
  cell.due_ns = time_ns;
  if (takes_time()) {
    plan(index);
  } else if (time_ns < cell.scheduled_ns) {
    lane_of_cell(index).queue.push(cell.scheduled_ns = time_ns, static_cast<std::uint32_t>(index));
  }
}

void Network::wake_unit(std::size_t index, std::int64_t time_ns) {
  Unit& unit = units_[index];
  unit.due_ns = time_ns;
  if (time_ns < unit.scheduled_ns)
    lane_of_unit(index).queue.push(unit.scheduled_ns = time_ns, unit_event | static_cast<std::uint32_t>(index));
}

// ---- Wires ----

void Network::start(std::uint32_t index, const std::uint8_t* frame, std::int64_t begin_ns) {
  Wire& wire = wires_[index];
  wire.frame = frame;
  const bool of_cell = index < cell_wires();
  Lane& lane = lane_of_wire(index);
  double duration_ns = of_cell ? frame_us * cells_[index / RS_PORTS].ns_per_us : 1e3 * frame_us;
  if (wire.to >= 0) {
    ++lane.counts.frames_sent;
    if (options_.line.jitter_us > 0)
      duration_ns += 1e3 * options_.line.jitter_us * random_unit(scramble(wire_keys_ + index), 4ULL * wire.frames);
  }
  ++wire.frames;
  wire.end_ns = begin_ns + static_cast<std::int64_t>(duration_ns);
  if (wire.troubled && of_cell) wire.end_ns += cells_[index / RS_PORTS].slow_ns;
  lane.queue.push(wire.end_ns, wire_event | index);
  tell([&](Observer& observer) { observer.frame_sent(*this, end_of(index), frame); });
}

void Network::finish(Lane& lane, std::uint32_t index) {
  Wire& wire = wires_[index];
  wire.end_ns = never;
  const std::uint8_t* frame = wire.frame;
  wire.frame = nullptr;
  std::uint8_t damaged[RS_FRAME_BYTES];
  const auto cells_end = static_cast<std::uint32_t>(cell_wires());

  if (wire.to >= 0) {
    double lost_share = options_.line.lost_share, bit_error_rate = options_.line.bit_error_rate;
    if (wire.troubled) {
      lost_share += troubles_[index].lost_share;
      bit_error_rate += troubles_[index].bit_error_rate;
    }
    const std::uint64_t key = scramble(wire_keys_ + index), draw = 4 * (wire.frames - 1ULL);
    bool damage = false;
    bool lost = wire.severed != 0 || wire.torn || (lost_share > 0 && random_unit(key, draw + 1) < lost_share);
    if (bit_error_rate > 0 && !lost) {
      const double intact = std::exp(double{RS_FRAME_BITS} * std::log1p(-bit_error_rate));
      if (random_unit(key, draw + 2) >= intact) {
        std::memcpy(damaged, frame, RS_FRAME_BYTES);
        const std::uint64_t bits = random_bits(key, draw + 3);
        const std::uint64_t flips = 1 + ((bits >> 56) & 1) + ((bits >> 57) & (bits >> 58) & 1);
        for (std::uint64_t k = 0; k < flips; ++k) {
          const std::uint64_t at = ((bits >> (16 * k)) & 0xFFFF) % RS_FRAME_BITS;
          damaged[at / 8] ^= static_cast<std::uint8_t>(1U << (at % 8));
        }
        frame = damaged;
        damage = true;
        ++lane.counts.frames_damaged;
      }
    }
    const auto to = static_cast<std::uint32_t>(wire.to);
    const bool overrun = to < cells_end && !lost && !has_room(to, frame);
    if (overrun) ++lane.counts.frames_overrun;
    lost = lost || overrun ||
           (to < cells_end ? cells_[to / RS_PORTS].power != Cell::Power::on
                           : units_[(to - cells_end) / RS_SECTION_UNIT_PORTS_MAX].stopped);
    lane.log(static_cast<std::uint64_t>(lane.now_ns) ^ (static_cast<std::uint64_t>(index) << 40) ^ (lost ? 1U : 0U));
    lane.log((static_cast<std::uint64_t>(rs_load32(frame)) << 32) | rs_load32(frame + 16));
    lane.log((static_cast<std::uint64_t>(rs_load32(frame + 4)) << 32) | (rs_load32(frame + 8) ^ rs_load32(frame + 12)));
    tell([&](Observer& observer) {
      observer.frame_ended(*this, end_of(index), end_of(to), frame,
                           overrun  ? FrameFate::overrun
                           : lost   ? FrameFate::lost
                           : damage ? FrameFate::damaged
                                    : FrameFate::delivered);
    });
    if (lost) {
      ++lane.counts.frames_lost;
    } else if (to < cells_end) {
      ++lane.counts.frames_delivered;
      if (wires_[to].taped)
        for (RunningFault& act : acts_)
          if (const auto heard = type_of(act.fault).heard) heard(act, to, frame);
      arrive(to, frame);
    } else {
      ++lane.counts.frames_delivered;
      rs_unit_input input{};
      input.kind = RS_UNIT_INPUT_FRAME;
      input.port = static_cast<std::uint8_t>((to - cells_end) % RS_SECTION_UNIT_PORTS_MAX + 1);
      input.bytes = frame;
      step_unit((to - cells_end) / RS_SECTION_UNIT_PORTS_MAX, input);
    }
  }

  wire.torn = false;
  if (index < cells_end) {
    let_go(index);
  } else {
    if (units_[(index - cells_end) / RS_SECTION_UNIT_PORTS_MAX].stopped) return;
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_SENT;
    input.port = static_cast<std::uint8_t>((index - cells_end) % RS_SECTION_UNIT_PORTS_MAX + 1);
    step_unit((index - cells_end) / RS_SECTION_UNIT_PORTS_MAX, input);
  }
}

void Network::wake_unit_now(Lane& lane, std::size_t index) {
  Unit& unit = units_[index];
  if (unit.scheduled_ns != lane.now_ns) return;
  unit.scheduled_ns = never;
  if (unit.due_ns > lane.now_ns) {
    if (unit.due_ns != never) wake_unit(index, unit.due_ns);
    return;
  }
  if (unit.stopped) return;
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_TIMER;
  step_unit(index, input);
}

void Network::wake(Lane& lane, std::size_t index) {
  Cell& cell = cells_[index];
  if (cell.scheduled_ns != lane.now_ns) return;
  cell.scheduled_ns = never;
  if (takes_time() && cell.power == Cell::Power::on) {
    serve(index);
    return;
  }
  if (cell.due_ns > lane.now_ns) {
    if (cell.due_ns != never) wake_cell(index, cell.due_ns);
    return;
  }
  if (cell.power == Cell::Power::on) {
    const std::uint32_t now_us = cell.clock_us(lane.now_ns);
    rs_input input{};
    input.kind = RS_INPUT_TIMER;
    if (cell.sampling && due(now_us, cell.sample_us)) {
      input.kind = RS_INPUT_SAMPLE;
      input.fault = source_.sample(index, lane.now_ns, cell.sample);
      input.sample = &cell.sample;
    }
    step_cell(index, input);
  } else if (cell.power == Cell::Power::starting) {
    boot(index);
  } else if (cell.power == Cell::Power::zombie) {
    run_zombie(index);
  }
}

// Begins to load what the event will touch; thousands of cells do not fit the near caches.
void Network::fetch(std::uint32_t what) const {
  const auto fetch_cell = [this](std::size_t index) {
    const Cell& cell = cells_[index];
    __builtin_prefetch(&cell);
    __builtin_prefetch(&cell.state);
    __builtin_prefetch(&cell.state.queues);
    __builtin_prefetch(&cell.state.route.parent_port);
  };
  if ((what & wire_event) != 0) {
    const Wire& wire = wires_[what & ~wire_event];
    const std::size_t from = what & ~wire_event, cells_end = cell_wires();
    if (from < cells_end) fetch_cell(from / RS_PORTS);
    __builtin_prefetch(wire.frame);
    const auto to = static_cast<std::size_t>(wire.to);
    if (wire.to >= 0 && to < cells_end) {
      fetch_cell(to / RS_PORTS);
      __builtin_prefetch(&cells_[to / RS_PORTS].state.route.neighbour[to % RS_PORTS]);
    }
  } else if (what < cells_.size()) {
    fetch_cell(what);
  }
}

void Network::run(Lane& lane, std::int64_t end_ns) {
  Event event;
  while (lane.queue.pop_before(end_ns, event)) {
    lane.now_ns = event.time_ns;
    fetch(lane.queue.next_what(unit_event));
    ++lane.counts.events;
    if ((event.what & wire_event) != 0) {
      const std::uint32_t wire = event.what & ~wire_event;
      if (wires_[wire].end_ns == event.time_ns) finish(lane, wire);
    } else if ((event.what & unit_event) != 0) {
      wake_unit_now(lane, event.what & ~unit_event);
    } else if ((event.what & letter_event) != 0) {
      deliver_letter(lane, event.what & ~letter_event);
    } else {
      wake(lane, event.what);
    }
  }
  lane.now_ns = std::max(lane.now_ns, end_ns);
}

// A fault may strike anywhere: it waits until all lanes have come to its time.
void Network::run_until(std::int64_t end_ns) {
  while (!acts_due_.empty() && acts_due_.front().time_ns < end_ns) {
    const Event next = acts_due_.front();
    acts_due_.erase(acts_due_.begin());
    run_lanes(next.time_ns);
    ++lanes_.front().counts.events;
    act(next.what);
  }
  run_lanes(end_ns);
}

void Network::contribute(std::size_t index, const rs_contribution& contribution) {
  Cell& cell = cells_.at(index);
  cell.contribution = contribution;
  if (cell.power == Cell::Power::on) rs_cell_contribute(&cell.state, &contribution);
}

void Network::set_torque_image(std::size_t index, std::span<const std::uint8_t, RS_TORQUE_IMAGE_BYTES> image) {
  std::copy(image.begin(), image.end(), cells_.at(index).flash + RS_FLASH_TORQUE_AT);
}

void Network::put(std::size_t index, ExternalCell& external) {
  cells_.at(index);
  external_index_ = index;
  external_ = &external;
}

void Network::receive(std::size_t unit, std::span<const std::uint8_t> datagram) {
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_DATAGRAM;
  input.bytes = datagram.data();
  input.count = static_cast<std::uint32_t>(datagram.size());
  Lane& lane = lanes_[lane_of_unit_.at(unit)];
  lane.log(static_cast<std::uint64_t>(lane.now_ns) ^ (datagram.size() << 48) ^ unit);
  tell([&](Observer& observer) { observer.datagram_from_host(*this, unit, datagram); });
  if (units_.at(unit).stopped) return;
  step_unit(unit, input);
}

}  // namespace robotskin::world
