// SPDX-License-Identifier: Apache-2.0
// Fills the SkinState of a control cycle from the driver's newest samples: SI units, tare, health.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "driver/sample.hpp"
#include "driver/snapshot_table.hpp"
#include "robotskin/timing.h"
#include "skin/calibration.hpp"
#include "skin/read_witness.hpp"
#include "skin/skin_model.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::skin {

struct ReaderOptions {
  // A cell in clock mode is stale beyond five of its own periods, but not before `clock_fresh_ns` (five at 250 Hz)
  // times the rate divisor in force, nor after `event_fresh_ns`.
  std::int64_t clock_fresh_ns = 20'000'000;
  // Event mode: a full frame comes within RS_FRESH_US even if one is lost, and may take a while on the host's side.
  std::int64_t event_fresh_ns = (RS_FRESH_US + 50'000) * std::int64_t{1000};
  std::int64_t stuck_after_ns = 5'000'000'000;  // acceleration unchanged for so long, while that of others changes
  std::int64_t moving_within_ns = 1'000'000'000;
  float tare_limit_n = 0.5F;  // an offset beyond it is a touch or a broken sensor, and is left in
};

class SkinReader {
 public:
  // `samples` must hold a row for each cell of the model, in its order. Throws std::invalid_argument otherwise.
  SkinReader(driver::SnapshotTable<driver::Sample>& samples, const SkinModel& model, const ReaderOptions& options = {});

  // The cycle: no allocation, no waiting. `state` must have the model's size (std::invalid_argument); `now_ns` is the
  // host clock. Always the same state object: values of cells that have nothing new are left as they stand in it.
  void read(std::int64_t now_ns, SkinState& state);

  std::size_t cell_count() const noexcept { return cells_; }
  // No living cell's sample is older, in any mode.
  std::int64_t longest_fresh_ns() const noexcept { return std::max(options_.clock_fresh_ns, options_.event_fresh_ns); }

  // From the next `read` on and for `duration_ns`, averages the forces of every cell; then subtracts the average.
  // Nothing may touch the skin meanwhile.
  void tare(std::int64_t duration_ns);
  bool taring() const { return tare_ns_ != 0; }
  std::size_t tare_refused() const { return tare_refused_; }  // force sensors whose offset passed the limit
  const std::vector<std::array<float, 3>>& force_offset() const { return force_offset_; }  // (N, 3) newton

  // (N, 3) newton of each cell's last sample as its sensors show it: without calibration, before any zero is taken.
  const std::vector<std::array<float, 3>>& measured_force() const { return measured_force_; }

  // Lets `witness` look on from the next call on, or none (null). It must outlive the reader.
  void set_witness(ReadWitness* witness) { witness_ = witness; }

  // All that the next read depends on beside the samples, as bytes: shown where they lie, without a copy, until the
  // next call. `restore` takes them in; throws std::invalid_argument for bytes of another skin or another version, and
  // changes nothing then.
  static constexpr std::size_t keyframe_parts_count = 5;
  std::array<std::span<const std::uint8_t>, keyframe_parts_count> keyframe_parts() const;
  void restore(std::span<const std::uint8_t> keyframe);

 private:
  void observe_period(std::size_t cell, const driver::Sample& sample);
  std::int64_t fresh_ns(std::size_t cell, const driver::Sample& sample) const;
  void take(std::size_t cell, const driver::Sample& sample, SkinState& state);
  void convert(std::size_t cell, const driver::Sample& sample, SkinState& state);
  std::array<float, 3> felt(std::size_t cell, const std::array<float, 3>& shown) const;
  void finish_tare(std::int64_t now_ns);
  bool anything_moves(std::span<const driver::Sample> samples, std::int64_t now_ns) const;

  driver::SnapshotTable<driver::Sample>& samples_;
  ReaderOptions options_;
  std::size_t cells_;
  std::vector<std::uint32_t> taken_;  // frames of the cell when its values were last converted
  struct Cadence {
    std::int64_t stamp_ns = 0;   // of the sample seen last
    std::int64_t period_ns = 0;  // between samples in clock mode; 0: not known
    std::uint8_t sequence = 0;
    std::uint8_t clock = 0;  // 1: the sample was sent by the clock; no bool, as it is restored from bytes
  };
  std::vector<Cadence> cadence_;
  std::vector<ForceCalibration> calibration_;  // (N), or none
  std::vector<std::array<float, 3>> force_offset_, measured_force_;
  struct Sum {
    std::array<float, 3> force{};
    std::uint32_t count = 0;
  };
  std::vector<Sum> sum_;
  std::int64_t tare_ns_ = 0;  // duration asked for; 0: none
  std::int64_t tare_end_ns_ = 0;
  std::size_t tare_refused_ = 0;
  const SkinState* last_ = nullptr;
  bool restored_ = false;  // the next read fills its state with all that was taken before
  ReadWitness* witness_ = nullptr;
  mutable std::array<std::int64_t, 4> keyframe_header_{};  // what keyframe_parts shows first
};

}  // namespace robotskin::skin
