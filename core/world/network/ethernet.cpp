// SPDX-License-Identifier: Apache-2.0
// Datagrams between the section units of a group: a fixed delay, and what faults do to them.
#include <algorithm>

#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {

void Network::post_to_peers(std::size_t from, std::span<const std::uint8_t> datagram) {
  log(static_cast<std::uint64_t>(now_ns_) ^ (datagram.size() << 32) ^ from);
  for (std::size_t to = 0; to < units_.size(); ++to) {
    if (to == from || units_[to].config.group != units_[from].config.group) continue;
    FaultyPassage passage{from, to, ethernet_ns, 0};
    if (!ethernet_faults_.empty())
      passage.chance = random_unit(stream_key(options_.seed, purpose_ethernet, 0), letters_posted_);
    for (const Fault& fault : ethernet_faults_) type_of(fault).passage(fault, passage);
    ++letters_posted_;
    if (passage.lost) {
      tell([&](Observer& observer) { observer.datagram_to_peer(*this, from, to, datagram, false); });
      continue;
    }
    auto place = std::ranges::find(in_flight_, never, &InFlightDatagram::due_ns);
    if (place == in_flight_.end()) place = in_flight_.emplace(in_flight_.end());
    place->due_ns = now_ns_ + passage.delay_ns;
    place->from = static_cast<std::uint32_t>(from);
    place->to = static_cast<std::uint32_t>(to);
    place->bytes = static_cast<std::uint32_t>(datagram.size());
    std::ranges::copy(datagram, place->datagram.begin());
    queue_.push(place->due_ns, letter_event | static_cast<std::uint32_t>(place - in_flight_.begin()));
  }
}

void Network::deliver_letter(std::size_t index) {
  const InFlightDatagram letter = in_flight_[index];
  in_flight_[index].due_ns = never;
  const std::span<const std::uint8_t> datagram(letter.datagram.data(), letter.bytes);
  log(static_cast<std::uint64_t>(now_ns_) ^ (datagram.size() << 48) ^ letter.to);
  tell([&](Observer& observer) { observer.datagram_to_peer(*this, letter.from, letter.to, datagram, true); });
  if (units_[letter.to].stopped) return;
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_DATAGRAM;
  input.bytes = datagram.data();
  input.count = letter.bytes;
  step_unit(letter.to, input);
}

}  // namespace robotskin::world
