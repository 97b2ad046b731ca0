#include "world/world.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace robotskin::world {
namespace {

// 30 degrees Celsius, 1 g upwards, nothing near.
constexpr rs_sample still = {{0, 0, 0, 0, 0, 0, 256, 60, 960}};

}  // namespace

void Mailbox::send(std::size_t unit, std::span<const std::uint8_t> datagram) {
  if (up_.size() == letters_max) {
    up_.pop_front();
    ++overflowed_;
  }
  up_.push_back({unit, clock_ == nullptr ? 0 : clock_->time_ns(), {datagram.begin(), datagram.end()}});
}

void Mailbox::deliver(Network& network) {
  for (const Letter& letter : down_) network.receive(letter.unit, letter.datagram);
  down_.clear();
}

void Mailbox::post(std::size_t unit, std::span<const std::uint8_t> datagram) {
  down_.push_back({unit, 0, {datagram.begin(), datagram.end()}});
}

std::vector<Mailbox::Letter> Mailbox::take() {
  std::vector<Letter> taken(std::make_move_iterator(up_.begin()), std::make_move_iterator(up_.end()));
  up_.clear();
  return taken;
}

World::World(Body* body, const Wiring& wiring, const NetworkOptions& options, Transport& transport, double step_s)
    : body_(body),
      transport_(transport),
      step_ns_(std::llround(1e9 * (body == nullptr ? step_s : body->timestep_s()))),
      network_(wiring, options, *this, transport) {}

void World::run(std::int64_t duration_ns) {
  const std::int64_t end_ns = time_ns() + duration_ns;
  while (time_ns() < end_ns) {
    const std::int64_t now_ns = time_ns();
    if (body_ != nullptr) body_->step(now_ns);
    transport_.deliver(network_);
    network_.run_until(now_ns + step_ns_);
    transport_.flush();
    if (formed_ns_ < 0 && network_.formed()) formed_ns_ = time_ns();
  }
}

bool World::sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) {
  if (body_ != nullptr) return body_->sample(cell, time_ns, sample);
  sample = still;
  return false;
}

}  // namespace robotskin::world
