// SPDX-License-Identifier: Apache-2.0
#include "world/world.hpp"

#include <chrono>
#include <cmath>

namespace robotskin::world {
namespace {

using Clock = std::chrono::steady_clock;

std::int64_t nanoseconds(Clock::duration duration) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
}

// 30 degrees Celsius, 1 g upwards, nothing near.
constexpr rs_sample still = {{0, 0, 0, 0, 0, 0, 256, 60, 960}};

}  // namespace

World::World(Body* body, const Wiring& wiring, const NetworkOptions& options, Transport& transport, double step_s)
    : body_(body),
      transport_(transport),
      step_ns_(std::llround(1e9 * (body == nullptr ? step_s : body->timestep_s()))),
      network_(wiring, options, *this, transport) {}

void World::run(std::int64_t duration_ns) {
  const std::int64_t end_ns = time_ns() + duration_ns;
  while (time_ns() < end_ns) {
    const std::int64_t now_ns = time_ns();
    const auto began = Clock::now();
    if (body_ != nullptr) body_->step(now_ns);
    const auto moved = Clock::now();
    transport_.deliver(network_);
    network_.run_until(now_ns + step_ns_);
    body_took_ns_ += nanoseconds(moved - began);
    network_took_ns_ += nanoseconds(Clock::now() - moved);
    if (formed_ns_ < 0 && network_.formed()) formed_ns_ = time_ns();
  }
}

bool World::sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) {
  if (body_ != nullptr) return body_->sample(cell, time_ns, sample);
  sample = still;
  return false;
}

}  // namespace robotskin::world
