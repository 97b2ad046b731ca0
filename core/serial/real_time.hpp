// SPDX-License-Identifier: Apache-2.0
// A loop in real time on a thread of its own: it sleeps until something is due or comes, and tells when it woke late.
#pragma once

#include <poll.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace robotskin::serial {

inline constexpr std::int64_t stall_ns = 3'000'000;  // a link falls after 3.5 ms of silence

struct Stalls {
  std::uint64_t count = 0;    // turns that came more than `stall_ns` late
  std::int64_t worst_ns = 0;  // by which one came late
  bool realtime = false;      // the thread goes before all that are not real-time
};

class RealTime {
 public:
  RealTime() = default;
  virtual ~RealTime() = default;
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;

  // `realtime`: asks the system to let the thread go before others. Once started it runs until `stop`.
  void start(bool realtime);
  void stop();  // must be called before the parts of a derived class end

  Stalls stalls() const;
  void forget_stalls();

 protected:
  // All of a turn; when the next one is due. `now_ns`: the calendar's time at the start, going on without a step.
  virtual std::int64_t turn(std::int64_t now_ns) = 0;
  // What to wait for beside time.
  virtual void wait_for(std::vector<pollfd>& descriptors) const = 0;
  // A turn holds this while it works.
  mutable std::mutex working_;

  std::int64_t now_ns() const;
  // Sleeps are not shorter: what comes due sooner is done together.
  std::int64_t least_sleep_ns_ = 20'000;

 private:
  void run();

  std::int64_t ahead_ns_ = calendar_ahead_ns();
  std::atomic<bool> ending_{false}, wanted_realtime_{false};
  Stalls stalls_;
  std::thread thread_;

  static std::int64_t calendar_ahead_ns();
};

}  // namespace robotskin::serial
