// SPDX-License-Identifier: Apache-2.0
#include "serial/serial_line.hpp"

#include <asm/termbits.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "robotskin/wire.h"
#include "serial/serial_error.hpp"

namespace robotskin::serial {
namespace {

constexpr std::int64_t retry_ns = 200'000'000;

}  // namespace

void check_latency_timer(const std::string& path, const std::string& sysfs) {
  std::error_code ignored;
  const std::filesystem::path device = std::filesystem::canonical(path, ignored);
  const std::string timer = sysfs + "/bus/usb-serial/devices/" + device.filename().string() + "/latency_timer";
  std::ifstream file(timer);
  int found_ms = 0;
  if (file >> found_ms && found_ms > longest_latency_ms)
    throw SerialError("serial line " + path + ": found a latency timer of " + std::to_string(found_ms) +
                      " ms, expected at most " + std::to_string(longest_latency_ms) + " ms; run 'echo 1 | sudo tee " +
                      timer + "'");
}

bool set_up_for_frames(int descriptor) {
  termios2 settings{};
  if (ioctl(descriptor, TCGETS2, &settings) != 0) return false;
  settings.c_iflag = 0;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | (BOTHER << IBSHIFT);
  settings.c_ispeed = settings.c_ospeed = RS_LINK_BAUD;
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  if (ioctl(descriptor, TCSETS2, &settings) != 0) return false;
  // A driver takes the nearest rate that it has: 3 % beside it no byte is right any more.
  if (ioctl(descriptor, TCGETS2, &settings) != 0) return false;
  const auto rate = static_cast<std::int64_t>(settings.c_ospeed);
  return std::abs(rate - RS_LINK_BAUD) * 100 <= 3 * RS_LINK_BAUD;
}

SerialLine::SerialLine(std::string path, std::string sysfs) : path_(std::move(path)), sysfs_(std::move(sysfs)) {
  open_or_throw();
}

SerialLine::~SerialLine() {
  if (descriptor_ >= 0) close(descriptor_);
}

void SerialLine::open_or_throw() {
  const int opened = open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (opened < 0) throw SerialError("serial line " + path_ + ": " + std::strerror(errno));
  try {
    if (isatty(opened) == 0) throw SerialError("serial line " + path_ + ": is no terminal");
    check_latency_timer(path_, sysfs_);
    if (!set_up_for_frames(opened))
      throw SerialError("serial line " + path_ + ": does not take " + std::to_string(RS_LINK_BAUD) + " baud");
  } catch (...) {
    close(opened);
    throw;
  }
  ioctl(opened, TCFLSH, TCIOFLUSH);
  descriptor_ = opened;
}

void SerialLine::lose() {
  close(descriptor_);
  descriptor_ = -1;
  ++pulled_;
}

std::size_t SerialLine::read(std::span<std::uint8_t> bytes) {
  if (descriptor_ < 0) return 0;
  const ssize_t count = ::read(descriptor_, bytes.data(), bytes.size());
  if (count > 0) return static_cast<std::size_t>(count);
  // With nothing there a terminal answers with none; one whose other end is gone with an error.
  if (count < 0 && errno != EAGAIN && errno != EINTR) lose();
  return 0;
}

bool SerialLine::write(std::span<const std::uint8_t> bytes) {
  if (descriptor_ < 0) return false;
  const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
  if (count < 0 && errno != EAGAIN && errno != EINTR) lose();
  return count == static_cast<ssize_t>(bytes.size());
}

void SerialLine::tend(std::int64_t now_ns) {
  if (descriptor_ >= 0 || now_ns < try_ns_) return;
  try_ns_ = now_ns + retry_ns;
  try {
    open_or_throw();
  } catch (const SerialError&) {
    // It is tried again.
  }
}

}  // namespace robotskin::serial
