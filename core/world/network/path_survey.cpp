// SPDX-License-Identifier: Apache-2.0
#include "world/network/path_survey.hpp"

namespace robotskin::world {
namespace {

constexpr std::int32_t unknown = -2, no_way = -1;

// The cell or port at the other end, if frames go both ways.
WireEnd usable_end(const Network& network, WireEnd from) {
  if (!network.carries(from)) return {};
  const WireEnd to = network.other_end(from);
  return network.carries(to) ? to : WireEnd{};
}

WireEnd cell_end(std::size_t cell, std::size_t port) {
  return {WireEnd::At::cell, static_cast<std::uint8_t>(port), static_cast<std::uint32_t>(cell)};
}

}  // namespace

void PathSurvey::reach() {
  depth_.assign(network_.cell_count(), no_way);
  queue_.clear();
  for (std::uint32_t u = 0; u < network_.unit_count(); ++u) {
    for (std::uint8_t p = 1; p <= network_.unit(u).config.ports; ++p) {
      if (!network_.unit_runs(u) || !network_.port_powered(u, p)) continue;
      const WireEnd to = usable_end(network_, {WireEnd::At::unit, p, u});
      if (to.at != WireEnd::At::cell || depth_[to.index] >= 0) continue;
      depth_[to.index] = 1;
      queue_.push_back(to.index);
    }
  }
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    for (std::size_t p = 1; p <= RS_PORTS; ++p) {
      const WireEnd to = usable_end(network_, cell_end(queue_[i], p));
      if (to.at != WireEnd::At::cell || depth_[to.index] >= 0) continue;
      depth_[to.index] = depth_[queue_[i]] + 1;
      queue_.push_back(to.index);
    }
  }
}

std::int32_t PathSurvey::follow(std::size_t cell) {
  // Down to a cell whose way is known, leaving marks against circles; then back.
  queue_.clear();
  std::int32_t known = no_way;
  for (std::size_t at = cell;;) {
    if (hops_[at] != unknown) {
      known = hops_[at];
      break;
    }
    hops_[at] = no_way;
    queue_.push_back(static_cast<std::uint32_t>(at));
    const unsigned port = network_.cell(at).route.parent_port;
    if (!network_.alive(at) || port < 1 || port > RS_PORTS) break;
    const WireEnd to = usable_end(network_, cell_end(at, port));
    if (to.at == WireEnd::At::unit && network_.port_powered(to.index, to.port)) {
      known = 0;
      break;
    }
    if (to.at != WireEnd::At::cell) break;
    at = to.index;
  }
  for (std::size_t i = queue_.size(); i-- > 0;) hops_[queue_[i]] = known = known < 0 ? no_way : known + 1;
  return hops_[cell];
}

void PathSurvey::update() {
  if (revision_ != network_.topology_revision()) {
    revision_ = network_.topology_revision();
    reach();
  }
  hops_.assign(network_.cell_count(), unknown);
  whole_ = shortest_ = true;
  for (std::size_t i = 0; i < hops_.size(); ++i) {
    if (hops_[i] == unknown) follow(i);
    if (depth_[i] < 0) continue;
    whole_ = whole_ && hops_[i] >= 0;
    shortest_ = shortest_ && hops_[i] == depth_[i] && network_.cell(i).route.hops == depth_[i];
  }
}

}  // namespace robotskin::world
