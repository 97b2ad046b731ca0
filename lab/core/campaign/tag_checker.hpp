// SPDX-License-Identifier: Apache-2.0
// Whether keys and tags are those of docs/protocol.md (I19), by another program than the one that made them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/published_mac.hpp"

namespace robotskin::campaign {

class TagChecker {
 public:
  // The group's secret; none: nothing is signed.
  TagChecker(std::optional<MacBytes> secret, BreakLog& breaks);

  // What a section unit has sent.
  void frame_sent(const world::Network& network, std::size_t unit, const std::uint8_t* frame);
  // Looks at the keys of every cell.
  void poll(const world::Network& network, const GroundTruth& ground);

  std::uint64_t judged() const { return judged_; }  // frames

 private:
  struct Signed;

  MacBytes of_turn(const MacBytes& key, std::uint32_t turn) const;
  MacBytes of_cell(std::uint32_t uid) const;

  BreakLog& breaks_;
  std::optional<MacBytes> secret_;
  MacBytes group_{};
  std::uint64_t judged_ = 0;
};

}  // namespace robotskin::campaign
