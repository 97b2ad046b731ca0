// SPDX-License-Identifier: Apache-2.0
// The samples of another maker's skin, in SI units, put in by a thread of their own.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "driver/snapshot_table.hpp"
#include "skin/skin_input.hpp"

namespace robotskin::skin {

// What a cell of such a skin said last.
struct ForeignSample {
  std::int64_t stamp_ns = 0;  // host clock at the sample; 0: none has come
  std::uint32_t samples = 0;  // so far
  bool saturated = false;     // a channel is at the end of its range
#define ROBOTSKIN_COLUMN(name, is_signed, first, channels, column, blank, unit) Column<channels> column{};
  RS_SENSORS(ROBOTSKIN_COLUMN)
#undef ROBOTSKIN_COLUMN
};

struct ForeignOptions {
  SensorSet sensors = only(Sensor::force);  // that this skin has
  std::int64_t fresh_ns = sample_fresh_ns;  // how old a sample of a living cell may be
  float tare_limit_n = 0.5F;                // an offset beyond it is a touch or a broken sensor, and is left in
};

// One thread changes cells and publishes them; the loop's thread reads; neither waits for the other.
class ForeignInput final : public SkinInput {
 public:
  // Throws std::invalid_argument for no cell, no sensor, or a bound of 0 or less.
  ForeignInput(std::size_t cells, const ForeignOptions& options);

  // ---- The thread that has the samples ----

  // Of a cell, to be changed; handed over by the next `publish`.
  ForeignSample& change(std::size_t cell) { return table_.change(cell); }
  void publish(std::int64_t now_ns) { table_.publish(now_ns); }
  // No more will come: the skin is disconnected. From any thread.
  void end() noexcept { ended_.store(true, std::memory_order_release); }

  // ---- The loop's thread ----

  std::size_t cell_count() const noexcept override { return cells_; }
  SensorSet sensors() const noexcept override { return options_.sensors; }
  std::int64_t fresh_ns() const noexcept override { return options_.fresh_ns; }
  [[nodiscard]] InputStatus read(std::int64_t now_ns, SkinState& state) noexcept override;

  // From the next `read` on and for `duration_ns`, averages the forces of every cell; then subtracts the average.
  // Nothing may touch the skin meanwhile. Throws std::invalid_argument for a duration of 0 or less.
  void tare(std::int64_t duration_ns);
  bool taring() const noexcept { return tare_ns_ != 0; }
  std::size_t tare_refused() const noexcept { return tare_refused_; }  // cells whose offset passed the limit

 private:
  void take(std::size_t cell, const ForeignSample& sample, SkinState& state) noexcept;
  void finish_tare() noexcept;

  struct Sum {
    std::array<float, 3> force{};
    std::uint32_t count = 0;
  };

  std::size_t cells_;
  ForeignOptions options_;
  driver::SnapshotTable<ForeignSample> table_;
  std::vector<std::uint32_t> taken_;
  std::vector<std::array<float, 3>> force_offset_;
  std::vector<Sum> sum_;
  std::uint64_t publication_ = 0;  // read last
  std::int64_t tare_ns_ = 0, tare_end_ns_ = 0;
  std::size_t tare_refused_ = 0;
  std::atomic<bool> ended_{false};
};

}  // namespace robotskin::skin
