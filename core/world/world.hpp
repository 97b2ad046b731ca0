// Body and network in step: physics every millisecond, the network's events in between, datagrams out and in.
//
// In: pushes of hands, commands of the robot, datagrams of the host. Out: datagrams of the section units. The same code
// runs in process or over UDP, in real time or as fast as it can: only the transport and the caller's pace differ.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "world/body.hpp"
#include "world/network.hpp"

namespace robotskin::world {

// Carries datagrams between section units and host.
class Transport : public DatagramSink {
 public:
  // Everything the host has sent, given to `network` at its present time.
  virtual void deliver(Network& network) = 0;
  // Everything the section units have sent is on its way when this returns.
  virtual void flush() = 0;
};

// In process: datagrams wait until they are taken; if nobody does, the oldest give way and are counted.
class Mailbox : public Transport {
 public:
  static constexpr std::size_t letters_max = 65536;

  struct Letter {
    std::size_t unit;
    std::int64_t time_ns;  // virtual
    std::vector<std::uint8_t> datagram;
  };

  void send(std::size_t unit, std::span<const std::uint8_t> datagram) override;
  void deliver(Network& network) override;
  void flush() override {}

  void post(std::size_t unit, std::span<const std::uint8_t> datagram);  // from the host
  std::vector<Letter> take();                                           // to the host, in the order sent
  std::uint64_t overflowed() const { return overflowed_; }
  void set_clock(const Network* network) { clock_ = network; }

 private:
  const Network* clock_ = nullptr;
  std::deque<Letter> up_;
  std::vector<Letter> down_;
  std::uint64_t overflowed_ = 0;
};

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

 private:
  Body* body_;
  Transport& transport_;
  std::int64_t step_ns_;
  std::int64_t formed_ns_ = -1;
  Network network_;
};

}  // namespace robotskin::world
