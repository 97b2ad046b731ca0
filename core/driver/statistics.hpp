// SPDX-License-Identifier: Apache-2.0
// What the driver counts: all that the evaluation of the skin network logs. Written by the driver's thread alone, read
// by any thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "robotskin/channels.h"

namespace robotskin::driver {

class Counter {
 public:
  void add(std::uint64_t more = 1) {
    value_.store(value_.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  }
  void set(std::uint64_t value) { value_.store(value, std::memory_order_relaxed); }
  std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

// clang-format off
// X(name, meaning): what becomes of a datagram; each is counted under exactly one name.
#define ROBOTSKIN_DATAGRAM_VERDICTS(X)                                                              \
  X(accepted, "taken")                                                                              \
  X(truncated, "shorter or longer than its header says")                                            \
  X(foreign, "not of this protocol or version, or of a section-unit group that was not asked for")  \
  X(malformed, "a kind, flag or session that no section unit sends")                                \
  X(unauthenticated, "without a right tag although a key is set")                                   \
  X(unanswering, "of an earlier exchange: does not answer this driver's session")                   \
  X(duplicated, "seen before")                                                                      \
  X(replayed, "of an ended session, or older than the window of the present one")                   \
  X(unit_refused, "no room for another section unit")

// X(name, meaning): what else is counted.
#define ROBOTSKIN_DRIVER_COUNTS(X)                                                                  \
  X(bytes, "received, of all datagrams")                                                            \
  X(datagrams_lost, "gaps in the sequences of the section units")                                   \
  X(frames, "in accepted datagrams")                                                                \
  X(clock_frames, "samples in clock mode")                                                          \
  X(event_frames, "samples in event mode, refreshes included")                                      \
  X(refresh_frames, "event-mode samples sent for freshness")                                        \
  X(further_frames, "samples of channels that a sample frame has no room for")                      \
  X(topology_frames, "neighbour lists")                                                             \
  X(ports_closed, "times that a cell told of a port closed by wrong tags")                          \
  X(reply_frames, "answers to commands")                                                            \
  X(status_frames, "subtree sizes")                                                                 \
  X(join_frames, "cells that ask for an id")                                                        \
  X(torque_frames, "torque sums")                                                                   \
  X(torque_vectors, "of limbs, joined from them")                                                   \
  X(torque_partial, "of those, that lacked the sum of a part or a section unit")                    \
  X(torque_saturated, "of those, in which a sum had left its range")                                \
  X(torque_late, "torque sums that came after their limb's vector")                                 \
  X(joints_sent, "joint positions of a limb's part, into the cell network")                         \
  X(frames_invalid, "of a type or id that no cell sends upward")                                    \
  X(frames_unknown_cell, "of cells that are not in the model")                                      \
  X(frames_late, "overtaken by a newer sample of the same cell")                                    \
  X(frames_duplicated, "samples that had come before: sent again after a failure")                  \
  X(frames_missing, "gaps in the cells' sequences, less what came late")                            \
  X(frames_dropped_by_units, "that section units say they had to drop")                             \
  X(replies_dropped, "answers not fetched in time")                                                 \
  X(sessions, "section units that started or restarted")                                            \
  X(publications, "snapshots handed out")                                                           \
  X(keep_alives_sent, "to section units")                                                           \
  X(commands_sent, "into the cell network")                                                         \
  X(wakes, "of the receiving thread")                                                               \
  X(thread_cpu_ns, "processor time of the receiving thread")                                        \
  X(socket_dropped, "datagrams the operating system dropped for want of buffer")
// clang-format on

enum class Verdict : std::uint8_t {
#define ROBOTSKIN_NAME(name, meaning) name,
  ROBOTSKIN_DATAGRAM_VERDICTS(ROBOTSKIN_NAME)
#undef ROBOTSKIN_NAME
};

// Time from a datagram's leaving the section unit to the snapshot that holds it, beyond the least such time
// (clock_offset.hpp): counts of 10 us, the last one open.
struct LatencyHistogram {
  static constexpr std::int64_t step_ns = 10'000;
  static constexpr std::size_t steps = 1000;
  std::array<Counter, steps> count;

  void take(std::int64_t latency_ns) {
    const auto step = static_cast<std::size_t>(latency_ns < 0 ? 0 : latency_ns / step_ns);
    count[step < steps ? step : steps - 1].add();
  }
};

struct Statistics {
#define ROBOTSKIN_MEMBER(name, meaning) Counter name;
  ROBOTSKIN_DATAGRAM_VERDICTS(ROBOTSKIN_MEMBER)
  ROBOTSKIN_DRIVER_COUNTS(ROBOTSKIN_MEMBER)
  // Event frames in which a sensor's counts changed, one for each of its channels.
#define ROBOTSKIN_SENSOR_EVENTS(name, ...) Counter events_##name;
  RS_SENSORS(ROBOTSKIN_SENSOR_EVENTS)
#undef ROBOTSKIN_SENSOR_EVENTS
#undef ROBOTSKIN_MEMBER
  LatencyHistogram latency;

  Counter& of(Verdict verdict) {
    switch (verdict) {
#define ROBOTSKIN_CASE(name, meaning) \
  case Verdict::name:                 \
    return name;
      ROBOTSKIN_DATAGRAM_VERDICTS(ROBOTSKIN_CASE)
#undef ROBOTSKIN_CASE
    }
    return malformed;
  }
};

}  // namespace robotskin::driver
