// SPDX-License-Identifier: Apache-2.0
// What a planted frame changes in the cell that it is handed: nothing (I19).
//
// A frame under a wrong tag, and one that was true once, must leave alone whatever a tag protects: route and time,
// wants and moves, settings, name and joints. What it says of its sender is not protected and not looked at. Two things
// are out of a cell's reach: a cell that has lost all its parents for long cannot know what time it has become, takes
// any time that was ever signed, and goes on from there until the true one comes; and a command's last repetition is
// answered again.
#pragma once

#include <cstdint>

#include "campaign/ground_truth.hpp"
#include "campaign/invariants.hpp"
#include "campaign/route_checker.hpp"

namespace robotskin::campaign {

class ForgeryChecker {
 public:
  explicit ForgeryChecker(BreakLog& breaks) : breaks_(breaks) {}

  // The cell's next step takes the frame.
  void frame_planted(const world::Network& network, const GroundTruth& ground, const RouteChecker& routes,
                     std::size_t cell, unsigned port, const std::uint8_t* frame, bool forged);
  void cell_stepped(const world::Network& network, std::size_t cell);
  // The cell of the frame just planted has been alone for so long that it may believe it.
  bool may_take_time() const { return planted_frame_.may_take_time; }
  // A tick that names no root, as cells say them that have just booted.
  bool bears_no_tag() const { return planted_frame_.no_tag; }
  std::uint64_t planted() const { return planted_; }

 private:
  struct Planted {
    bool waits = false, forged = false, may_take_time = false, unnamed = false, no_tag = false;
    std::size_t cell = 0;
    unsigned port = 0;
    rs_frame_type type = RS_TYPE_LIMIT;
    rs_wave wave{};  // in it
    rs_route route{};
    rs_settings settings{};
    rs_joints_state joints{};
    std::uint32_t led_rgb = 0;
    std::uint16_t id = 0, counter = 0;
    std::uint8_t down = 0;  // frames waiting to go down
  };

  BreakLog& breaks_;
  Planted planted_frame_;
  std::uint64_t planted_ = 0;
};

}  // namespace robotskin::campaign
