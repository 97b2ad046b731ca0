// SPDX-License-Identifier: Apache-2.0
#include "world/network/external_cell.hpp"

#include <algorithm>

namespace robotskin::world {
namespace {

// What differs, or nothing.
std::string difference(const rs_output& own, const ExternalCellOutput& external) {
  for (std::size_t port = 0; port < RS_PORTS; ++port) {
    const auto& frame = external.frame[port];
    if ((own.frame[port] != nullptr) != frame.has_value()) return "whether a frame goes out on port";
    if (frame && !std::equal(frame->begin(), frame->end(), own.frame[port])) return "a frame";
  }
  if (own.timer_us != external.timer_us) return "the timer";
  if (own.sampling != external.sample_us.has_value()) return "whether it samples";
  if (own.sampling && own.sample_us != *external.sample_us) return "the time of the sample";
  if (own.waiting != external.waiting) return "the ports it waits for";
  if (own.led_changed != external.led_rgb.has_value() || (own.led_changed && own.led_rgb != *external.led_rgb))
    return "the LED";
  if (own.flash_changed != external.flash.has_value()) return "whether it writes flash";
  if (own.flash_changed &&
      !std::equal(external.flash->begin(), external.flash->end(), own.flash, own.flash + RS_FLASH_BYTES))
    return "the flash image";
  if (own.restart != external.restart) return "whether it restarts";
  return {};
}

}  // namespace

void ExternalCell::step(const rs_input& input, InputKind kind, std::uint32_t now_us, rs_output& output) {
  kind_ = kind;
  const ExternalCellOutput external = step_(input, now_us);
  ++steps_;
  samples_ += input.kind == RS_INPUT_SAMPLE;
  const std::string what = difference(output, external);
  if (!what.empty() && ++differences_ == 1) {
    first_difference_ = what + " at step " + std::to_string(steps_) + ", input " + std::to_string(input.kind) +
                        " on port " + std::to_string(input.port) + ", " + std::to_string(now_us) + " us";
  }
  for (std::size_t port = 0; port < RS_PORTS; ++port) {
    if (!external.frame[port]) {
      output.frame[port] = nullptr;
      continue;
    }
    ++frames_;
    sending_[port] = *external.frame[port];
    output.frame[port] = sending_[port].data();
  }
}

}  // namespace robotskin::world
