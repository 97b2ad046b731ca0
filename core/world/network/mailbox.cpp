// SPDX-License-Identifier: Apache-2.0
#include "world/network/mailbox.hpp"

#include <iterator>

namespace robotskin::world {

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

}  // namespace robotskin::world
