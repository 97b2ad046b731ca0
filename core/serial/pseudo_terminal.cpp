// SPDX-License-Identifier: Apache-2.0
#include "serial/pseudo_terminal.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "serial/serial_error.hpp"
#include "serial/serial_line.hpp"

namespace robotskin::serial {

PseudoTerminal::PseudoTerminal(std::string name) : name_(std::move(name)) {
  const auto fail = [this](const std::string& why) {
    const SerialError error("pseudo-terminal " + name_ + ": " + why);
    if (own_ >= 0) close(own_);
    if (other_ >= 0) close(other_);
    throw error;
  };
  own_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (own_ < 0 || grantpt(own_) != 0 || unlockpt(own_) != 0) fail(std::strerror(errno));
  char path[128];
  if (ptsname_r(own_, path, sizeof path) != 0) fail(std::strerror(errno));
  other_ = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (other_ < 0) fail(std::strerror(errno));
  if (!set_up_for_frames(other_)) fail("takes no such rate");
  std::error_code error;
  if (std::filesystem::is_symlink(name_)) std::filesystem::remove(name_, error);
  std::filesystem::create_symlink(path, name_, error);
  if (error) fail(error.message());
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  std::filesystem::remove(name_, ignored);
  close(other_);
  close(own_);
}

std::size_t PseudoTerminal::read(std::span<std::uint8_t> bytes) {
  const ssize_t count = ::read(own_, bytes.data(), bytes.size());
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

// What finds no room, because nothing reads the other end, is lost as on a wire.
bool PseudoTerminal::write(std::span<const std::uint8_t> bytes) {
  return ::write(own_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
}

}  // namespace robotskin::serial
