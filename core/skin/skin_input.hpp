// SPDX-License-Identifier: Apache-2.0
// Where a skin's samples come from: the driver's datagrams, a recording, another maker's skin, a generator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "skin/skin_state.hpp"
#include "skin/torque_reader.hpp"

namespace robotskin::skin {

enum class InputStatus : std::uint8_t {
  ok,
  nothing_new,   // nothing was measured since the last read; the state is left as it was
  disconnected,  // the skin does not answer
};

// A cell whose sample is older than this is stale, unless its input allows for more.
inline constexpr std::int64_t sample_fresh_ns = 50'000'000;
// A sample may be stamped this much later than the loop's clock, which was read before it; later is impossible.
inline constexpr std::int64_t sample_ahead_ns = 10'000'000;

// Called from the control loop: no function blocks, allocates or throws.
class SkinInput {
 public:
  virtual ~SkinInput() = default;

  virtual std::size_t cell_count() const noexcept = 0;
  // That its cells have. The state that it fills has no others; it leaves their columns alone.
  virtual SensorSet sensors() const noexcept { return all_sensors; }

  // Fills what is new in a state of cell_count() cells, in the order of the skin model; `now_ns` is the loop's clock.
  // It is always the same state. Of each cell with something new it sets values, `stamp_ns` and `health`, and it sets
  // `time_ns` of the state to the host clock at which the newest of it was handed out: a skin whose time stands still
  // is lost. What it calls alive is checked once more (distrust).
  [[nodiscard]] virtual InputStatus read(std::int64_t now_ns, SkinState& state) noexcept = 0;

  // How old a sample of a living cell may be.
  virtual std::int64_t fresh_ns() const noexcept { return sample_fresh_ns; }

  // position (n) rad or m of the robot's joints, for skins whose cells compute with it.
  virtual void tell_joints(std::int64_t /*now_ns*/, std::span<const double> /*position*/) noexcept {}
  // What the skin has computed itself; null where it computes nothing.
  virtual const SkinTorque* skin_computed_torque() const noexcept { return nullptr; }
};

// What an input calls alive but cannot be: a sample older than `fresh_ns` or from the future is stale, a force or a
// proximity that is no number, or below 0, is stuck.
void distrust(std::int64_t now_ns, std::int64_t fresh_ns, SkinState& state) noexcept;

}  // namespace robotskin::skin
