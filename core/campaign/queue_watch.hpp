// How long samples wait in a cell, and that queues stay within their size (I13).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "campaign/ground.hpp"
#include "campaign/invariants.hpp"
#include "campaign/recovery_watch.hpp"

namespace robotskin::campaign {

class QueueWatch {
 public:
  static constexpr std::int64_t waiting_max_ns = 8 * ms;

  QueueWatch(std::size_t cells, BreakLog& breaks) : breaks_(breaks), cells_(cells) {}

  // `within_load`: no port has more cells than it can carry.
  void cell_stepped(const world::Network& network, const Ground& ground, const RecoveryWatch& recovery,
                    std::size_t cell, bool within_load);

  std::int64_t longest_ns() const { return longest_ns_; }

 private:
  // When what stands at each place of the ring came in.
  struct Cell {
    std::array<std::int64_t, RS_QUEUE_DATA> since_ns{};
    std::uint8_t first = 0, count = 0;
    std::uint32_t dropped = 0;
  };

  BreakLog& breaks_;
  std::vector<Cell> cells_;
  std::int64_t longest_ns_ = 0;
};

}  // namespace robotskin::campaign
