// SPDX-License-Identifier: Apache-2.0
// Which cells a network could reach, and which have a way to a section unit at this moment.
//
// Physical reach: over wires that carry both ways, through cells that run, to a powered port of a unit that runs. A
// way: parent after parent over such wires, without a circle.
#pragma once

#include <cstdint>
#include <vector>

#include "world/network/network.hpp"

namespace robotskin::world {

class PathSurvey {
 public:
  explicit PathSurvey(const Network& network) : network_(network) {}

  // Looks at everything anew; `depth` only if wires or running cells have changed.
  void update();

  const std::vector<std::int32_t>& depth() const { return depth_; }  // (N) fewest hops to a port, -1: out of reach
  const std::vector<std::int32_t>& hops() const { return hops_; }    // (N) along parents, -1: no way
  bool whole() const { return whole_; }                              // every cell in reach has a way
  bool shortest() const { return shortest_; }                        // and that is as short as can be

 private:
  void reach();
  std::int32_t follow(std::size_t cell);

  const Network& network_;
  std::uint64_t revision_ = ~std::uint64_t{0};
  std::vector<std::int32_t> depth_, hops_;
  std::vector<std::uint32_t> queue_;
  bool whole_ = false, shortest_ = false;
};

}  // namespace robotskin::world
