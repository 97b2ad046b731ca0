// SPDX-License-Identifier: Apache-2.0
// One TCP connection to a controller. Nothing here waits longer than it is told to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace robotskin::ur {

class TcpSocket {
 public:
  TcpSocket() = default;
  // Throws UrError, naming the address, where nothing answers within the time.
  TcpSocket(const std::string& host, std::uint16_t port, double within_s);
  ~TcpSocket() { close(); }
  TcpSocket(TcpSocket&& other) noexcept;
  TcpSocket& operator=(TcpSocket&& other) noexcept;

  bool open() const noexcept { return descriptor_ >= 0; }
  int descriptor() const noexcept { return descriptor_; }
  void close() noexcept;

  // All of the bytes, or false: the connection is gone, or does not take them within the time.
  [[nodiscard]] bool send(std::span<const std::uint8_t> bytes, double within_s) const noexcept;
  [[nodiscard]] bool send(std::string_view text, double within_s) const noexcept;
  // What has arrived: the count of bytes, 0 for none, -1 for a connection that is gone.
  [[nodiscard]] int receive(std::span<std::uint8_t> bytes) const noexcept;
  // Whether something arrives within the time.
  bool wait(double within_s) const noexcept;
  // A line without its end. Throws UrError where none comes within the time.
  std::string line(double within_s);

 private:
  int descriptor_ = -1;
  std::string told_;     // host and port, for messages
  std::string pending_;  // after the last line
};

}  // namespace robotskin::ur
