// SPDX-License-Identifier: Apache-2.0
// A serial line of this machine at 4 Mb/s 8N1: a UART, a USB adapter or the end of a pseudo-terminal.
#pragma once

#include <string>

#include "serial/line.hpp"

namespace robotskin::serial {

// An adapter holds bytes back for as long as its latency timer says. Cells lose their links after 3.5 ms of silence.
inline constexpr int longest_latency_ms = 2;

// Throws SerialError for an adapter whose timer is set to more; one without a timer is fine. `sysfs`: where the system
// tells of its devices.
void check_latency_timer(const std::string& path, const std::string& sysfs);

// Sets a descriptor of a terminal to 4 Mb/s, 8 bits, no parity, no flow control, no meaning of any byte; false if it
// does not take that.
bool set_up_for_frames(int descriptor);

class SerialLine : public Line {
 public:
  // Throws SerialError: no such line, no terminal, another rate, a latency timer that is too long.
  explicit SerialLine(std::string path, std::string sysfs = "/sys");
  ~SerialLine() override;
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  const std::string& path() const { return path_; }
  int descriptor() const override { return descriptor_; }
  std::size_t read(std::span<std::uint8_t> bytes) override;
  bool write(std::span<const std::uint8_t> bytes) override;
  void tend(std::int64_t now_ns) override;
  std::uint64_t pulled() const override { return pulled_; }

 private:
  void open_or_throw();
  void lose();

  std::string path_, sysfs_;
  int descriptor_ = -1;
  std::int64_t try_ns_ = 0;
  std::uint64_t pulled_ = 0;
};

}  // namespace robotskin::serial
