// SPDX-License-Identifier: Apache-2.0
// Channels beyond the nine go all the way: from the world through the cells' firmware, the network and the driver to
// the state of the skin and to the columns of a recording. Usage: check_further_channels SEED. Built with the channels
// of further_channels.h.
#include <cmath>
#include <cstdlib>
#include <vector>

#include "check.hpp"
#include "driver/driver.hpp"
#include "record/sample_columns.hpp"
#include "skin/skin_reader.hpp"
#include "world/network/network.hpp"
#include "world/sensors.hpp"

using namespace robotskin;

namespace {

constexpr std::int32_t columns = 6, rows = 4, cells = columns * rows;

world::Wiring sheet() {
  world::Wiring wiring;
  wiring.neighbours.resize(cells);
  wiring.id.resize(cells);
  for (std::int32_t cell = 0; cell < cells; ++cell) {
    wiring.id[static_cast<std::size_t>(cell)] = static_cast<std::uint16_t>(cell + 1);
    auto& own = wiring.neighbours[static_cast<std::size_t>(cell)];
    if ((cell + 1) % columns != 0) {
      own[0] = {cell + 1, 4};
      wiring.neighbours[static_cast<std::size_t>(cell) + 1][3] = {cell, 1};
    }
    if (cell + columns < cells) {
      own[1] = {cell + columns, 3};
      wiring.neighbours[static_cast<std::size_t>(cell + columns)][2] = {cell, 2};
    }
  }
  world::UnitDescription unit;
  unit.ports = {{0, 3}};
  wiring.units = {unit};
  return wiring;
}

// The skin of every cell has a temperature of its own, which its hygrometer feels as the world says. The gyroscope, of
// which the world says nothing, reads signed numbers of its own.
class Readings : public world::SampleSource {
 public:
  explicit Readings(std::uint64_t seed)
      : seed_(static_cast<std::int32_t>(seed % 97)), sensors_(cells, world::Imperfections::ideal(), seed) {}

  static double humidity(std::size_t cell) { return 40 + static_cast<double>(cell); }
  std::int32_t velocity(std::size_t cell, std::int32_t axis) const {
    return (axis == 1 ? -1 : 1) * (1000 * axis + 7 * static_cast<std::int32_t>(cell) + seed_) - 5000 * (axis == 2);
  }

  bool sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) override {
    world::Truth truth{};
    truth.distance_m = 1;
    truth.surface_temperature_c = 30 + 0.5 * static_cast<double>(cell);
    (void)sensors_.sample(cell, 1e-9 * static_cast<double>(time_ns), truth, sample);
    sample.value[RS_CHANNEL_force_2] = static_cast<std::int32_t>(cell);
    for (std::int32_t axis = 0; axis < 3; ++axis) {
      CHECK(sample.value[RS_CHANNEL_angular_velocity_x + axis] == 0);
      sample.value[RS_CHANNEL_angular_velocity_x + axis] = velocity(cell, axis);
    }
    return false;
  }

 private:
  std::int32_t seed_;
  world::Sensors sensors_;
};

class Host : public world::DatagramSink {
 public:
  void send(std::size_t, std::int64_t, std::span<const std::uint8_t> datagram) override {
    waiting.emplace_back(datagram.begin(), datagram.end());
  }
  std::vector<std::vector<std::uint8_t>> waiting;
};

}  // namespace

int main(int count, char** values) {
  const std::uint64_t seed = argument(count, values, 1, 1);
  Readings readings(seed);
  Host host;
  world::NetworkOptions network_options;
  network_options.seed = seed;
  network_options.line.lost_share = 1e-3;
  world::Network network(sheet(), network_options, readings, host);
  driver::Options options;
  skin::SkinModel model;
  for (std::uint32_t cell = 0; cell < cells; ++cell) model.key.push_back(cell + 1);
  options.keys = model.key;
  driver::Driver driver(options);
  skin::SkinReader reader(driver.samples(), model);
  skin::SkinState state;
  state.resize(cells);

  constexpr std::int64_t ms = 1'000'000, start_ns = 1'000'000'000;
  const auto run_until = [&](std::int64_t end_ms, bool further) {
    for (std::int64_t now_ns = network.time_ns() + ms; now_ns <= end_ms * ms; now_ns += ms) {
      network.run_until(now_ns);
      driver.downlink(start_ns + now_ns, [&](const driver::Recipient&, std::span<const std::uint8_t> datagram) {
        network.receive(0, datagram);
      });
      for (std::vector<std::uint8_t>& datagram : host.waiting) {
        for (std::size_t at = RS_DATAGRAM_HEADER_BYTES; !further && at + RS_DATAGRAM_RECORD_BYTES <= datagram.size();
             at += RS_DATAGRAM_RECORD_BYTES)
          if (rs_frame_type_of(&datagram[at]) == RS_TYPE_further)
            datagram[at] = static_cast<std::uint8_t>((RS_TYPE_LIMIT - 1) << 4);
        driver.handle(datagram, start_ns + now_ns);
      }
      host.waiting.clear();
      driver.publish(start_ns + now_ns);
      reader.read(start_ns + now_ns, state);
    }
  };

  CHECK(std::isnan(state.humidity[0]) && std::isnan(state.angular_velocity[0][2]));
  run_until(1000, true);
  CHECK(driver.statistics().further_frames.get() > 5 * cells);
  CHECK(driver.statistics().further_frames.get() < 9 * cells);
  double mean_error = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    CHECK(state.health[cell] == skin::Health::alive);
    CHECK(state.normal_force[cell][1] == static_cast<float>(cell) * 10.0F / 1024.0F);
    CHECK(std::abs(state.humidity[cell] - readings.humidity(cell)) < 2);
    mean_error += (state.humidity[cell] - readings.humidity(cell)) / cells;
    for (std::int32_t axis = 0; axis < 3; ++axis)
      CHECK(state.angular_velocity[cell][static_cast<std::size_t>(axis)] ==
            static_cast<float>(readings.velocity(cell, axis)) / 16.0F);
    CHECK(state.saturated[cell] == 0);
  }

  CHECK(std::abs(mean_error) < 0.3);

  // A recording has a column of each sensor.
  record::SampleColumns columns(model);
  for (std::size_t cell = 0; cell < cells; ++cell) columns.add(driver.samples().row(cell));
  CHECK(columns.humidity.size() == cells && columns.angular_velocity.size() == cells);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    CHECK(std::abs(columns.humidity[cell] - readings.humidity(cell)) < 2);
    CHECK(columns.angular_velocity[cell] == state.angular_velocity[cell]);
  }

  // What no longer comes does not look fresh, while the nine channels do.
  run_until(2300, false);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    CHECK(state.health[cell] == skin::Health::alive);
    CHECK(std::isnan(state.humidity[cell]) && std::isnan(state.angular_velocity[cell][0]));
    CHECK(state.normal_force[cell][1] == static_cast<float>(cell) * 10.0F / 1024.0F);
  }
}
