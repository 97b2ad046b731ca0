// SPDX-License-Identifier: Apache-2.0
#include "world/network/twin.hpp"

#include <algorithm>

namespace robotskin::world {
namespace {

// What differs, or nothing.
std::string difference(const rs_output& own, const TwinOutput& twin) {
  for (std::size_t port = 0; port < RS_PORTS; ++port) {
    const auto& frame = twin.frame[port];
    if ((own.frame[port] != nullptr) != frame.has_value()) return "whether a frame goes out on port";
    if (frame && !std::equal(frame->begin(), frame->end(), own.frame[port])) return "a frame";
  }
  if (own.timer_us != twin.timer_us) return "the timer";
  if (own.sampling != twin.sample_us.has_value()) return "whether it samples";
  if (own.sampling && own.sample_us != *twin.sample_us) return "the time of the sample";
  if (own.waiting != twin.waiting) return "the ports it waits for";
  if (own.led_changed != twin.led_rgb.has_value() || (own.led_changed && own.led_rgb != *twin.led_rgb))
    return "the LED";
  if (own.flash_changed != twin.flash.has_value()) return "whether it writes flash";
  if (own.flash_changed && !std::equal(twin.flash->begin(), twin.flash->end(), own.flash, own.flash + RS_FLASH_BYTES))
    return "the flash image";
  if (own.restart != twin.restart) return "whether it restarts";
  return {};
}

}  // namespace

void Twin::step(const rs_input& input, InputKind kind, std::uint32_t now_us, rs_output& output) {
  kind_ = kind;
  const TwinOutput twin = step_(input, now_us);
  ++steps_;
  samples_ += input.kind == RS_INPUT_SAMPLE;
  const std::string what = difference(output, twin);
  if (!what.empty() && ++differences_ == 1) {
    first_difference_ = what + " at step " + std::to_string(steps_) + ", input " + std::to_string(input.kind) +
                        " on port " + std::to_string(input.port) + ", " + std::to_string(now_us) + " us";
  }
  for (std::size_t port = 0; port < RS_PORTS; ++port) {
    if (!twin.frame[port]) {
      output.frame[port] = nullptr;
      continue;
    }
    ++frames_;
    sending_[port] = *twin.frame[port];
    output.frame[port] = sending_[port].data();
  }
}

}  // namespace robotskin::world
