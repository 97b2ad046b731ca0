// SPDX-License-Identifier: Apache-2.0
#include "world/network/in_process.hpp"

#include <iterator>

namespace robotskin::world {

void InProcess::send(std::size_t unit, std::int64_t time_ns, std::span<const std::uint8_t> datagram) {
  if (up_.size() == waiting_max) {
    up_.pop_front();
    ++overflowed_;
  }
  up_.push_back({unit, time_ns, {datagram.begin(), datagram.end()}});
}

void InProcess::deliver(Network& network) {
  for (const Waiting& letter : down_) network.receive(letter.unit, letter.datagram);
  down_.clear();
}

void InProcess::post(std::size_t unit, std::span<const std::uint8_t> datagram) {
  down_.push_back({unit, 0, {datagram.begin(), datagram.end()}});
}

std::vector<InProcess::Waiting> InProcess::take() {
  std::vector<Waiting> taken(std::make_move_iterator(up_.begin()), std::make_move_iterator(up_.end()));
  up_.clear();
  return taken;
}

}  // namespace robotskin::world
