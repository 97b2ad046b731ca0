// SPDX-License-Identifier: Apache-2.0
// A cell run elsewhere in place of one of the network's own: a chip in an emulator, or a real one at the desk.
//
// The network's own cell runs beside it on the same inputs, and every output is compared; on the wires go the external
// cell's frames. So the rest of the skin lives with the external cell, and any difference from a host-built cell is
// told.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "robotskin/cell.h"
#include "world/network/processor.hpp"

namespace robotskin::world {

struct ExternalCellOutput {
  std::array<std::optional<std::array<std::uint8_t, RS_FRAME_BYTES>>, RS_PORTS> frame;
  std::uint32_t timer_us = 0;
  std::optional<std::uint32_t> sample_us, led_rgb;
  std::uint8_t waiting = 0;
  std::optional<std::vector<std::uint8_t>> flash;
  bool restart = false;
};

class ExternalCell {
 public:
  using Step = std::function<ExternalCellOutput(const rs_input&, std::uint32_t now_us)>;

  explicit ExternalCell(Step step) : step_(std::move(step)) {}

  // Takes the input that the network's own cell has answered with `output`, whose frames become the external cell's.
  void step(const rs_input& input, InputKind kind, std::uint32_t now_us, rs_output& output);

  InputKind kind() const { return kind_; }  // of the input that the external cell has now
  std::uint64_t steps() const { return steps_; }
  std::uint64_t samples() const { return samples_; }
  std::uint64_t frames() const { return frames_; }            // that the external cell sent
  std::uint64_t differences() const { return differences_; }  // steps in which it answered otherwise
  const std::string& first_difference() const { return first_difference_; }

 private:
  Step step_;
  std::array<std::array<std::uint8_t, RS_FRAME_BYTES>, RS_PORTS> sending_{};
  InputKind kind_ = InputKind::boot;
  std::uint64_t steps_ = 0, samples_ = 0, frames_ = 0, differences_ = 0;
  std::string first_difference_;
};

}  // namespace robotskin::world
