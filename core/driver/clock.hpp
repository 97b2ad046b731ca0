// SPDX-License-Identifier: Apache-2.0
// The host's clock, and the place of a thread in the queue for a processor.
#pragma once

#include <sched.h>

#include <cstdint>
#include <ctime>

namespace robotskin::driver {

inline std::int64_t clock_ns(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

inline std::int64_t monotonic_ns() {
  return clock_ns(CLOCK_MONOTONIC);
}

// What the calendar is ahead of the host's clock: it goes on growing when the host restarts.
inline std::int64_t calendar_ns() {
  return clock_ns(CLOCK_REALTIME) - monotonic_ns();
}

// Puts the calling thread before all that are not real-time, but none that it starts; false if the system does not
// permit it.
inline bool become_realtime() {
  const sched_param priority{.sched_priority = 10};
  return sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &priority) == 0;
}

// The same as long as it lives, for a thread that is an ordinary one before and after.
class RealtimeWhile {
 public:
  explicit RealtimeWhile(bool wanted) : was_(wanted ? sched_getscheduler(0) : -1) {
    if (was_ >= 0 && sched_getparam(0, &priority_) == 0) realtime_ = become_realtime();
  }
  ~RealtimeWhile() {
    // The flag may be set without a privilege, but not taken back.
    if (realtime_) (void)sched_setscheduler(0, was_ | SCHED_RESET_ON_FORK, &priority_);
  }
  RealtimeWhile(const RealtimeWhile&) = delete;
  RealtimeWhile& operator=(const RealtimeWhile&) = delete;
  bool realtime() const { return realtime_; }

 private:
  int was_;
  sched_param priority_{};
  bool realtime_ = false;
};

}  // namespace robotskin::driver
