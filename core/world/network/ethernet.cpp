// SPDX-License-Identifier: Apache-2.0
// Datagrams between the section units of a group: a fixed delay, and what faults do to them.
#include <algorithm>

#include "world/network/fault_type.hpp"
#include "world/network/parts.hpp"
#include "world/random.hpp"

namespace robotskin::world {

void Network::post_to_peers(std::size_t from, std::span<const std::uint8_t> datagram) {
  Lane& lane = lane_of_unit(from);
  lane.log(static_cast<std::uint64_t>(lane.now_ns) ^ (datagram.size() << 32) ^ from);
  for (const std::uint32_t to : lane.units) {
    if (to == from || units_[to].config.group != units_[from].config.group) continue;
    FaultyPassage passage{from, to, ethernet_ns, 0};
    if (!ethernet_faults_.empty())
      passage.chance = random_unit(stream_key(options_.seed, purpose_ethernet, lane.number), lane.letters_posted);
    for (const Fault& fault : ethernet_faults_) type_of(fault).passage(fault, passage);
    ++lane.letters_posted;
    if (passage.lost) {
      tell([&](Observer& observer) { observer.datagram_to_peer(*this, from, to, datagram, false); });
      continue;
    }
    auto place = std::ranges::find(lane.in_flight, never, &InFlightDatagram::due_ns);
    if (place == lane.in_flight.end()) place = lane.in_flight.emplace(lane.in_flight.end());
    place->due_ns = lane.now_ns + passage.delay_ns;
    place->from = static_cast<std::uint32_t>(from);
    place->to = to;
    place->bytes = static_cast<std::uint32_t>(datagram.size());
    std::ranges::copy(datagram, place->datagram.begin());
    lane.queue.push(place->due_ns, letter_event | static_cast<std::uint32_t>(place - lane.in_flight.begin()));
  }
}

void Network::deliver_letter(Lane& lane, std::size_t index) {
  const InFlightDatagram letter = lane.in_flight[index];
  lane.in_flight[index].due_ns = never;
  const std::span<const std::uint8_t> datagram(letter.datagram.data(), letter.bytes);
  lane.log(static_cast<std::uint64_t>(lane.now_ns) ^ (datagram.size() << 48) ^ letter.to);
  tell([&](Observer& observer) { observer.datagram_to_peer(*this, letter.from, letter.to, datagram, true); });
  if (units_[letter.to].stopped) return;
  rs_unit_input input{};
  input.kind = RS_UNIT_INPUT_DATAGRAM;
  input.bytes = datagram.data();
  input.count = letter.bytes;
  step_unit(letter.to, input);
}

}  // namespace robotskin::world
