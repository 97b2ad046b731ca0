// SPDX-License-Identifier: Apache-2.0
#include "driver/receiver.hpp"

#include <sys/prctl.h>

#include "driver/clock.hpp"

namespace robotskin::driver {

Receiver::Receiver(Driver& driver, const Address& local, ReceiverOptions options)
    : driver_(driver), options_(std::move(options)), socket_(local, options_.buffer_bytes) {
  known_.reserve(Driver::units_max);
  pending_units_.reserve(Driver::units_max);
}

// Remembers where the datagram of the unit heard last came from: what is for it goes there.
void Receiver::learn(std::size_t datagram) {
  const Recipient unit = driver_.last_heard();
  std::vector<Known>& list = unit.pending ? pending_units_ : known_;
  for (Known& known : list) {
    if (known.unit.group != unit.group || known.unit.unit != unit.unit) continue;
    known.address = socket_.sender(datagram);
    return;
  }
  if (list.size() < Driver::units_max) list.push_back({unit, socket_.sender(datagram)});
}

void Receiver::send(const Recipient& to, std::span<const std::uint8_t> datagram) {
  if (to.unit == RS_UNIT_ALL) {
    for (const Address& address : options_.units) socket_.send(datagram, address);
    return;
  }
  for (const Known& known : to.pending ? pending_units_ : known_) {
    if (known.unit.group == to.group && known.unit.unit == to.unit) {
      socket_.send(datagram, known.address);
    }
  }
}

std::size_t Receiver::poll(std::optional<std::int64_t> time_ns) {
  const auto clock = [&] { return time_ns ? *time_ns : monotonic_ns(); };
  std::size_t taken = 0;
  while (taken < options_.datagrams_per_poll) {
    const std::size_t count = socket_.receive();
    const std::int64_t now_ns = clock();
    for (std::size_t i = 0; i < count; ++i) {
      const Verdict verdict = driver_.handle(socket_.datagram(i), now_ns);
      if (verdict == Verdict::accepted || verdict == Verdict::unanswering) learn(i);
    }
    taken += count;
    if (count < UdpSocket::batch) break;
  }
  const std::int64_t now_ns = clock();
  if (taken > 0) driver_.publish(now_ns);
  driver_.downlink(now_ns, [this](const Recipient& to, std::span<const std::uint8_t> bytes) { send(to, bytes); });
  return taken;
}

void Receiver::start() {
  if (running()) return;
  stopping_ = false;
  thread_ = std::thread([this] { run(); });
}

void Receiver::stop() {
  if (!running()) return;
  stopping_ = true;
  thread_.join();
}

void Receiver::run() {
  prctl(PR_SET_NAME, "skin driver");
  prctl(PR_SET_TIMERSLACK, 10'000UL);
  if (options_.realtime) become_realtime();
  Statistics& statistics = driver_.statistics();
  std::uint64_t dropped_before = socket_.dropped();
  for (unsigned wake = 0; !stopping_.load(std::memory_order_relaxed); ++wake) {
    const std::size_t taken = poll();
    statistics.wakes.add();
    if (wake % 64 == 0) {
      statistics.thread_cpu_ns.set(static_cast<std::uint64_t>(clock_ns(CLOCK_THREAD_CPUTIME_ID)));
      const std::uint64_t dropped = socket_.dropped();
      statistics.socket_dropped.add(dropped - dropped_before);
      dropped_before = dropped;
    }
    if (taken == 0) {
      socket_.wait(idle_ns);
    } else if (options_.batch_ns > 0) {
      const timespec pause{options_.batch_ns / 1'000'000'000, options_.batch_ns % 1'000'000'000};
      clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
    }
  }
}

}  // namespace robotskin::driver
