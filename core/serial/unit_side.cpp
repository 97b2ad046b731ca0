// SPDX-License-Identifier: Apache-2.0
#include "serial/unit_side.hpp"

#include <algorithm>

namespace robotskin::serial {

UnitSide::UnitSide(const UnitOptions& options, Outward& outward, std::int64_t now_ns)
    : outward_(outward), cell_key_(options.cell_key) {
  out_ns_.fill(never);
  if (options.key) hash_.emplace(*options.key);
  const unsigned ids = (RS_ID_LAST - RS_ID_FIRST + 1) / options.units;
  rs_section_unit_config config{};
  config.group = options.group;
  config.unit = options.unit;
  config.ports = options.ports;
  config.first_id = static_cast<std::uint16_t>(RS_ID_FIRST + options.unit * ids);
  config.last_id = static_cast<std::uint16_t>(RS_ID_FIRST + (options.unit + 1U) * ids - 1U);
  config.batch_us = options.batch_us;
  config.session = options.session;
  config.powered = true;
  config.unasked = options.unasked;
  config.cell_key = cell_key_ ? cell_key_->data() : nullptr;
  if (hash_) {
    config.tag = &driver::KeyedHash::hook;
    config.tag_context = &*hash_;
  }
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_BOOT;
  input.config = &config;
  step(input, now_ns);
}

void UnitSide::step(const rs_unit_input& input, std::int64_t now_ns) {
  rs_unit_output output;
  rs_section_unit_step(state_.get(), &input, static_cast<std::uint64_t>(now_ns), &output);
  for (unsigned port = 0; port < RS_SECTION_UNIT_PORTS_MAX; ++port) {
    if (output.frame[port] == nullptr) continue;
    out_ns_[port] = now_ns + frame_ns;
    outward_.frame(port + 1, FrameBytes(output.frame[port], RS_FRAME_BYTES), now_ns);
  }
  if (output.datagram != nullptr) outward_.datagram({output.datagram, output.datagram_bytes}, output.to_peers);
  timer_ns_ = static_cast<std::int64_t>(std::min<std::uint64_t>(output.timer_ns, static_cast<std::uint64_t>(never)));
}

void UnitSide::frame(unsigned port, FrameBytes frame, std::int64_t now_ns) {
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_FRAME;
  input.port = static_cast<std::uint8_t>(port);
  input.bytes = frame.data();
  step(input, now_ns);
}

bool UnitSide::datagram(std::span<const std::uint8_t> datagram, std::int64_t now_ns) {
  const std::uint32_t refused = state_->refused;
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_DATAGRAM;
  input.bytes = datagram.data();
  input.count = static_cast<std::uint32_t>(datagram.size());
  step(input, now_ns);
  return state_->refused == refused;
}

std::int64_t UnitSide::advance(std::int64_t now_ns) {
  for (unsigned port = 0; port < RS_SECTION_UNIT_PORTS_MAX; ++port) {
    if (out_ns_[port] > now_ns) continue;
    out_ns_[port] = never;
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_SENT;
    input.port = static_cast<std::uint8_t>(port + 1);
    step(input, now_ns);
  }
  if (timer_ns_ <= now_ns) {
    rs_unit_input input{};
    input.kind = RS_UNIT_INPUT_TIMER;
    step(input, now_ns);
  }
  return std::min(timer_ns_, *std::ranges::min_element(out_ns_));
}

}  // namespace robotskin::serial
