// SPDX-License-Identifier: Apache-2.0
// Body and network in step: physics every millisecond, the network's events in between, datagrams out and in.
//
// In: pushes of hands, commands of the robot, datagrams of the host. Out: datagrams of the section units. The same code
// runs in process or over UDP, in real time or as fast as it can: only the transport and the caller's pace differ.
#pragma once

#include <cstdint>

#include "world/body.hpp"
#include "world/network/network.hpp"
#include "world/network/transport.hpp"

namespace robotskin::world {

class World : public SampleSource {
 public:
  // Body and transport must outlive the world. Without a body the cells read what lies still in the air at 30 C.
  World(Body* body, const Wiring& wiring, const NetworkOptions& options, Transport& transport, double step_s = 0.001);

  // Runs for this long, in whole physics steps.
  void run(std::int64_t duration_ns);
  std::int64_t time_ns() const { return network_.time_ns(); }

  Network& network() { return network_; }
  const Network& network() const { return network_; }

  // Virtual time when every cell first had its shortest path, -1: not yet.
  std::int64_t formed_ns() const { return formed_ns_; }

  bool sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) override;

  // Real time that body and network have taken so far.
  std::int64_t body_took_ns() const { return body_took_ns_; }
  std::int64_t network_took_ns() const { return network_took_ns_; }

 private:
  Body* body_;
  Transport& transport_;
  std::int64_t step_ns_;
  std::int64_t formed_ns_ = -1;
  std::int64_t body_took_ns_ = 0, network_took_ns_ = 0;
  Network network_;
};

}  // namespace robotskin::world
