// SPDX-License-Identifier: Apache-2.0
#include "serial/virtual_skin.hpp"

#include <algorithm>

namespace robotskin::serial {

VirtualSkin::VirtualSkin(const UnitOptions& unit, std::vector<HostCell> cells, CellSensors& sensors,
                         std::int64_t epoch_ns, Take datagrams)
    : now_ns_(epoch_ns),
      datagrams_(std::move(datagrams)),
      pulled_(unit.ports, false),
      unit_(unit, *this, epoch_ns),
      cells_(std::move(cells), unit.cell_key, sensors, *this, epoch_ns) {}

void VirtualSkin::put(std::size_t line, bool up, FrameBytes frame, std::int64_t now_ns) {
  if (line >= pulled_.size() || pulled_[line]) return;
  InFlight flight{now_ns + frame_ns, line, up, {}};
  std::ranges::copy(frame, flight.frame.begin());
  in_flight_.push_back(flight);
}

void VirtualSkin::pull(std::size_t line, bool pulled) {
  pulled_.at(line) = pulled;
}

void VirtualSkin::run_until(std::int64_t end_ns) {
  for (;;) {
    const auto first = std::ranges::min_element(in_flight_, {}, &InFlight::due_ns);
    const std::int64_t arrives_ns = first == in_flight_.end() ? never : first->due_ns;
    const std::int64_t next_ns = std::min({arrives_ns, unit_.advance(now_ns_), cells_.advance(now_ns_)});
    // Either may have sent something meanwhile that arrives sooner: then `first` is looked for again.
    if (std::ranges::any_of(in_flight_, [&](const InFlight& one) { return one.due_ns < next_ns; })) continue;
    if (next_ns > end_ns) break;
    now_ns_ = std::max(now_ns_, next_ns);
    const auto arrived = std::ranges::find_if(in_flight_, [&](const InFlight& one) { return one.due_ns <= now_ns_; });
    if (arrived == in_flight_.end()) continue;
    const InFlight flight = *arrived;
    in_flight_.erase(arrived);
    if (flight.up)
      unit_.frame(static_cast<unsigned>(flight.line + 1), flight.frame, now_ns_);
    else
      cells_.frame(flight.line, flight.frame, now_ns_);
  }
  now_ns_ = end_ns;
}

}  // namespace robotskin::serial
