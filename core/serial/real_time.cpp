// SPDX-License-Identifier: Apache-2.0
#include "serial/real_time.hpp"

#include <sys/prctl.h>

#include <algorithm>

#include "driver/clock.hpp"

namespace robotskin::serial {
namespace {

constexpr std::int64_t longest_sleep_ns = 50'000'000;  // so that `stop` is heard, and lines are tended

}  // namespace

std::int64_t RealTime::calendar_ahead_ns() {
  return driver::calendar_ns();
}

std::int64_t RealTime::now_ns() const {
  return driver::monotonic_ns() + ahead_ns_;
}

void RealTime::start(bool realtime) {
  stop();
  ending_ = false;
  wanted_realtime_ = realtime;
  thread_ = std::thread(&RealTime::run, this);
}

void RealTime::stop() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
}

Stalls RealTime::stalls() const {
  const std::lock_guard lock(working_);
  return stalls_;
}

void RealTime::forget_stalls() {
  const std::lock_guard lock(working_);
  stalls_ = {.realtime = stalls_.realtime};
}

void RealTime::run() {
  prctl(PR_SET_TIMERSLACK, 1UL);
  const bool realtime = wanted_realtime_ && driver::become_realtime();
  std::vector<pollfd> descriptors;
  std::int64_t due_ns = now_ns();
  while (!ending_) {
    {
      const std::lock_guard lock(working_);
      const std::int64_t began_ns = now_ns(), late_ns = began_ns - due_ns;
      stalls_.realtime = realtime;
      stalls_.count += late_ns > stall_ns;
      stalls_.worst_ns = std::max(stalls_.worst_ns, late_ns);
      const std::int64_t next_ns = turn(began_ns);
      descriptors.clear();
      wait_for(descriptors);
      // From its beginning: a turn that is held up is a stall, too.
      due_ns = std::clamp(next_ns, began_ns + least_sleep_ns_, began_ns + longest_sleep_ns);
    }
    const std::int64_t sleep_ns = std::max<std::int64_t>(due_ns - now_ns(), 0);
    const timespec timeout{sleep_ns / 1'000'000'000, sleep_ns % 1'000'000'000};
    if (ppoll(descriptors.data(), descriptors.size(), &timeout, nullptr) > 0) due_ns = std::min(due_ns, now_ns());
  }
}

}  // namespace robotskin::serial
