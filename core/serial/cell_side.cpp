// SPDX-License-Identifier: Apache-2.0
#include "serial/cell_side.hpp"

#include <algorithm>
#include <cstring>

#include "robotskin/keys.h"
#include "robotskin/settings.h"
#include "serial/serial_error.hpp"

namespace robotskin::serial {
namespace {

constexpr std::int64_t restart_ns = 1'000'000, commissioned_ns = RS_COMMISSIONED_US * 1000LL;

}  // namespace

CellSide::CellSide(std::vector<HostCell> cells, std::optional<CellKey> key, CellSensors& sensors, Outward& outward,
                   std::int64_t now_ns)
    : cells_(cells.size()), key_(key), sensors_(sensors), outward_(outward) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Cell& cell = cells_[i];
    cell.made = cells[i];
    if (cell.made.factory) cell.commissioning.emplace();
    cell.out_ns.fill(never);
    cell.clock_start_us = cell.made.random * 2654435761U;
    rs_settings settings;
    rs_settings_default(&settings);
    settings.id = cell.made.id;
    cell.flash.fill(0xFF);
    rs_settings_store(&settings, cell.flash.data());
    for (unsigned port = 1; port <= RS_PORTS; ++port) {
      const WireEnd end = cell.made.ends[port - 1];
      if (end.cell >= static_cast<std::int32_t>(cells.size()) ||
          (end.cell >= 0 && (end.port < 1 || end.port > RS_PORTS)))
        throw SerialError("cell " + std::to_string(i) + " port " + std::to_string(port) + ": there is no cell " +
                          std::to_string(end.cell) + " with port " + std::to_string(end.port));
      if (end.line < 0) continue;
      line_ends_.resize(std::max<std::size_t>(line_ends_.size(), static_cast<std::size_t>(end.line) + 1));
      line_ends_[end.line] = {static_cast<std::int32_t>(i), static_cast<std::uint8_t>(port), end.line};
    }
  }
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!cells_[i].commissioning) boot(i, now_ns);
}

const CellKeys* CellSide::given_keys(std::size_t cell) const {
  const Cell& asked = cells_.at(cell);
  return asked.made.keys ? &*asked.made.keys : nullptr;
}

void CellSide::note_kept(std::size_t cell) {
  cells_.at(cell).stored = true;
}

void CellSide::commission(Cell& cell, unsigned port, const std::uint8_t* frame, std::int64_t now_ns) {
  std::array<std::uint8_t, RS_FRAME_BYTES> answer;
  const rs_commissioning_do next = rs_commissioning_frame(&*cell.commissioning, cell.made.uid, frame, answer.data());
  if (next == RS_COMMISSIONING_NOTHING) return;
  if (next == RS_COMMISSIONING_KEEP) std::ranges::copy(cell.commissioning->keys, cell.made.keys.emplace().begin());
  if (cell.made.keys && !cell.stored) return;  // it is asked again
  if (cell.made.keys) {
    cell.due_ns = now_ns + commissioned_ns;
    events_.push({cell.due_ns, order_++, static_cast<std::uint32_t>(&cell - cells_.data()), RS_PORTS});
  }
  if (const std::int32_t line = cell.made.ends[port - 1].line; line >= 0)
    outward_.frame(static_cast<std::size_t>(line), answer, now_ns);
}

void CellSide::boot(std::size_t index, std::int64_t now_ns) {
  Cell& cell = cells_[index];
  rs_boot boot{};
  boot.uid = cell.made.uid;
  boot.random = cell.made.random++;
  boot.flash = cell.flash.data();
  CellKeys keys;
  if (key_) rs_cell_keys(key_->data(), boot.uid, keys.data());
  if (cell.made.keys) keys = *cell.made.keys;
  if (key_ || cell.made.keys) boot.keys = keys.data();
  rs_input input{};
  input.kind = RS_INPUT_BOOT;
  input.boot = &boot;
  step(index, input, now_ns);
}

void CellSide::step(std::size_t index, const rs_input& input, std::int64_t now_ns) {
  Cell& cell = cells_[index];
  rs_output output;
  const std::uint32_t now_us = clock_us(cell, now_ns);
  rs_cell_step(&cell.state, &input, now_us, &output);
  const auto at = static_cast<std::uint32_t>(index);
  for (std::uint32_t p = 0; p < RS_PORTS; ++p) {
    if (output.frame[p] == nullptr) continue;
    cell.sending[p] = output.frame[p];
    cell.out_ns[p] = now_ns + frame_ns;
    events_.push({cell.out_ns[p], order_++, at, p});
    // A line takes the whole frame at once; its other end has it no sooner than the wire would.
    if (const std::int32_t line = cell.made.ends[p].line; line >= 0)
      outward_.frame(static_cast<std::size_t>(line), FrameBytes(output.frame[p], RS_FRAME_BYTES), now_ns);
  }
  if (output.flash_changed) std::memcpy(cell.flash.data(), output.flash, RS_FLASH_BYTES);
  cell.sampling = output.sampling;
  cell.sample_us = output.sample_us;
  auto delay_us = static_cast<std::int32_t>(output.timer_us - now_us);
  if (output.sampling) delay_us = std::min(delay_us, static_cast<std::int32_t>(output.sample_us - now_us));
  const std::int64_t due_ns = now_ns + 1000LL * std::max(delay_us, 1);
  if (due_ns != cell.due_ns) {
    cell.due_ns = due_ns;
    events_.push({due_ns, order_++, at, RS_PORTS});
  }
  if (output.restart) boot(index, now_ns + restart_ns);
}

void CellSide::finish(std::size_t index, std::size_t port, std::int64_t now_ns) {
  Cell& cell = cells_[index];
  cell.out_ns[port] = never;
  const WireEnd end = cell.made.ends[port];
  if (end.cell >= 0) arrive(static_cast<std::size_t>(end.cell), end.port, cell.sending[port], now_ns);
  rs_input input{};
  input.kind = RS_INPUT_SENT;
  input.port = static_cast<std::uint8_t>(port + 1);
  step(index, input, now_ns);
}

void CellSide::wake(std::size_t index, std::int64_t now_ns) {
  Cell& cell = cells_[index];
  cell.due_ns = never;
  if (cell.commissioning) {
    cell.commissioning.reset();
    boot(index, now_ns);
    return;
  }
  rs_input input{};
  input.kind = RS_INPUT_TIMER;
  if (cell.sampling && static_cast<std::int32_t>(clock_us(cell, now_ns) - cell.sample_us) >= 0) {
    input.kind = RS_INPUT_SAMPLE;
    input.fault = sensors_.sense(index, cell.sample);
    input.sample = &cell.sample;
    ++samples_;
  }
  step(index, input, now_ns);
}

void CellSide::arrive(std::size_t index, unsigned port, const std::uint8_t* frame, std::int64_t now_ns) {
  if (cells_[index].commissioning) {
    commission(cells_[index], port, frame, now_ns);
    return;
  }
  rs_input input{};
  input.kind = RS_INPUT_FRAME;
  input.port = static_cast<std::uint8_t>(port);
  input.frame = frame;
  step(index, input, now_ns);
}

void CellSide::frame(std::size_t line, FrameBytes frame, std::int64_t now_ns) {
  advance(now_ns);
  if (line >= line_ends_.size() || line_ends_[line].cell < 0) return;
  arrive(static_cast<std::size_t>(line_ends_[line].cell), line_ends_[line].port, frame.data(), now_ns);
}

std::int64_t CellSide::advance(std::int64_t now_ns) {
  while (!events_.empty() && events_.top().time_ns <= now_ns) {
    const Event event = events_.top();
    events_.pop();
    Cell& cell = cells_[event.cell];
    if (event.port == RS_PORTS) {
      if (cell.due_ns == event.time_ns) wake(event.cell, event.time_ns);
    } else if (cell.out_ns[event.port] == event.time_ns) {
      finish(event.cell, event.port, event.time_ns);
    }
  }
  return events_.empty() ? never : events_.top().time_ns;
}

}  // namespace robotskin::serial
