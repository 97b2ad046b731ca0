// SPDX-License-Identifier: Apache-2.0
// The cycle of driver and skin state allocates nothing: a datagram in, publication, downlink, a SkinState out.
// Usage: check_cycle SEED STEPS. Prints how long a read of 1260 cells takes.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>

#include "check.hpp"
#include "driver/driver.hpp"
#include "skin/skin_reader.hpp"
#include "traffic/traffic.hpp"

namespace {
std::atomic<std::uint64_t> allocations{0};
}

void* operator new(std::size_t bytes) {
  ++allocations;
  if (void* memory = std::malloc(bytes)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  ++allocations;
  const std::size_t unit = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(unit, (bytes + unit - 1) / unit * unit)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

using namespace robotskin;

int main(int count, char** values) {
  const std::uint64_t seed = argument(count, values, 1, 1), steps = argument(count, values, 2, 2000);
  lab::TrafficOptions traffic_options;
  traffic_options.seed = seed;
  traffic_options.key = driver::Key{};
  lab::Traffic traffic(traffic_options);
  driver::Options options;
  options.keys = traffic.keys();
  options.key = driver::Key{};
  options.session_seed = seed;
  driver::Driver driver(options);
  skin::SkinModel model;
  model.key = traffic.keys();
  skin::SkinReader reader(driver.samples(), model);
  skin::SkinState state;
  state.resize(model.size());
  reader.tare(500'000'000);

  std::vector<std::vector<std::uint8_t>> datagrams;
  std::vector<std::int64_t> read_ns;
  read_ns.reserve(steps);
  std::int64_t now_ns = 1'000'000'000;
  for (std::uint64_t step = 0; step < steps; ++step) {
    now_ns += 1'000'000;
    std::size_t used = 0;
    traffic.step(static_cast<std::uint64_t>(now_ns), [&](std::span<const std::uint8_t> bytes) {
      if (used == datagrams.size()) datagrams.emplace_back();
      datagrams[used++].assign(bytes.begin(), bytes.end());
    });
    if (step % 500 == 250) driver.command({.group = 0, .operation = RS_OPERATION_led, .value = 0xFF});
    std::uint8_t heard[4][RS_DATAGRAM_BYTES_MAX];
    std::size_t heard_bytes[4] = {}, heard_count = 0;

    const std::uint64_t before = allocations;
    for (std::size_t i = 0; i < used; ++i) driver.handle(datagrams[i], now_ns);
    driver.publish(now_ns);
    const auto start = std::chrono::steady_clock::now();
    reader.read(now_ns, state);
    read_ns.push_back((std::chrono::steady_clock::now() - start).count());
    struct Out {
      std::uint8_t (*bytes)[RS_DATAGRAM_BYTES_MAX];
      std::size_t* sizes;
      std::size_t* count;
    } out{heard, heard_bytes, &heard_count};
    const auto hear = [&out](const driver::Recipient&, std::span<const std::uint8_t> bytes) {
      if (*out.count == 4) return;
      std::copy(bytes.begin(), bytes.end(), out.bytes[*out.count]);
      out.sizes[(*out.count)++] = bytes.size();
    };
    driver.downlink(now_ns, std::cref(hear));
    CHECK(allocations == before);

    for (std::size_t i = 0; i < heard_count; ++i) traffic.hear({heard[i], heard_bytes[i]});
  }
  CHECK(driver.statistics().clock_frames.get() > 0);
  std::sort(read_ns.begin(), read_ns.end());
  std::printf("read of %zu cells: median %.2f us, p99 %.2f us, worst %.2f us\n", model.size(),
              static_cast<double>(read_ns[steps / 2]) * 1e-3, static_cast<double>(read_ns[steps * 99 / 100]) * 1e-3,
              static_cast<double>(read_ns.back()) * 1e-3);
}
