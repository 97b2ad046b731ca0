// SPDX-License-Identifier: Apache-2.0
// Drives a Driver from a UDP socket: polled by the caller, or by a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "driver/driver.hpp"
#include "driver/udp_socket.hpp"

namespace robotskin::driver {

struct ReceiverOptions {
  bool realtime = false;            // the thread runs before all that are not real-time, where the system permits it
  std::vector<Address> units;       // section units to wake; those heard from are answered anyway
  std::int64_t batch_ns = 800'000;  // pause between two wakes while datagrams come: one wake serves them all
  int buffer_bytes = 32 << 20;      // receive buffer asked of the operating system
  std::size_t datagrams_per_poll = 8192;  // at most, before what came is published
};

class Receiver {
 public:
  // Throws std::system_error if the address cannot be bound.
  Receiver(Driver& driver, const Address& local, ReceiverOptions options);
  ~Receiver() { stop(); }

  // Takes everything that has arrived, publishes it, sends what is due; datagrams taken. Not while the thread runs.
  // `time_ns`: the time it is, for a world in virtual time; by default the host's clock.
  std::size_t poll(std::optional<std::int64_t> time_ns = {});

  void start();
  void stop();
  bool running() const { return thread_.joinable(); }

  const UdpSocket& socket() const { return socket_; }

 private:
  static constexpr std::int64_t idle_ns = 10'000'000;  // longest wait for a first datagram

  struct Known {
    Recipient unit;
    Address address;
  };

  void run();
  void learn(std::size_t datagram);
  void send(const Recipient& to, std::span<const std::uint8_t> datagram);

  Driver& driver_;
  ReceiverOptions options_;
  UdpSocket socket_;
  std::vector<Known> known_;          // where accepted datagrams came from
  std::vector<Known> pending_units_;  // where others with a right tag came from: they change nothing of the former
  std::thread thread_;
  std::atomic<bool> stopping_{false};
};

}  // namespace robotskin::driver
