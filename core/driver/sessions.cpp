// SPDX-License-Identifier: Apache-2.0
// Sessions: whose datagrams are believed, and which of them are fresh.
#include <algorithm>

#include "driver/driver.hpp"

namespace robotskin::driver {

void Driver::draw_session() {
  do {
    // splitmix64
    std::uint64_t z = random_ += 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    session_ = static_cast<std::uint32_t>((z ^ (z >> 31)) >> 32);
  } while (session_ == 0 || answers_us(session_));
  std::rotate(own_sessions_.begin(), own_sessions_.end() - 1, own_sessions_.end());
  own_sessions_[0] = session_;
  sequence_ = 0;
  keep_alive_due_ = true;
}

bool Driver::answers_us(std::uint32_t session) const {
  return session != 0 && std::find(own_sessions_.begin(), own_sessions_.end(), session) != own_sessions_.end();
}

std::optional<std::size_t> Driver::find_unit(std::uint16_t group, std::uint8_t unit) {
  const std::uint32_t name = std::uint32_t{group} << 8 | unit;
  for (std::size_t i = 0; i < unit_count_; ++i) {
    if (unit_names_[i] == name) return i;
  }
  return std::nullopt;
}

// Notes a unit with a right tag that does not answer us, so that the next downlink answers it.
void Driver::register_unit(const rs_datagram_header& header) {
  last_heard_ = {header.group, header.unit, true};
  for (PendingUnit& pending : pending_units_) {
    if (pending.unit.group != header.group || pending.unit.unit != header.unit) continue;
    pending.session = header.session;
    pending.due = true;
    return;
  }
  if (pending_units_.size() < units_max) pending_units_.push_back({last_heard_, header.session, true});
}

// Decides whether a datagram is fresh. Changes nothing of the known units unless it is.
Verdict Driver::check_session(const rs_datagram_header& header, std::int64_t now_ns, bool trusted, std::size_t* unit) {
  if (!trusted && !answers_us(header.answering)) {
    register_unit(header);
    return Verdict::unanswering;
  }
  std::optional<std::size_t> known = find_unit(header.group, header.unit);
  const bool restarted = known && links_[*known].session != header.session;
  if (!known || restarted) {
    if (!trusted && header.answering != session_) {
      register_unit(header);
      return Verdict::unanswering;
    }
    if (!known && unit_count_ == units_max) return Verdict::unit_refused;
    if (restarted) {
      Link& link = links_[*known];
      if (std::find(link.ended.begin(), link.ended.end(), header.session) != link.ended.end()) return Verdict::replayed;
      link.ended[link.next_ended++ % link.ended.size()] = link.session;
      link.window.reset();
      link.clock.reset();
      link.missing_counted = 0;
      link.dropped = 0;
      draw_session();
    } else {
      known = unit_count_++;
      unit_names_[*known] = std::uint32_t{header.group} << 8 | header.unit;
      UnitRow& row = units_.change(*known);
      row.group = header.group;
      row.unit = header.unit;
    }
    links_[*known].session = header.session;
    statistics_.sessions.add();
    keep_alive_due_ = true;
  }
  Link& link = links_[*known];
  switch (link.window.take(header.sequence)) {
    case SequenceWindow::Verdict::seen:
      return Verdict::duplicated;
    case SequenceWindow::Verdict::too_old:
      return Verdict::replayed;
    case SequenceWindow::Verdict::fresh:
      break;
  }
  link.clock.take(header.time_ns, now_ns);
  *unit = *known;
  return Verdict::accepted;
}

}  // namespace robotskin::driver
