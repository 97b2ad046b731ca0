// SPDX-License-Identifier: Apache-2.0
// A bound UDP socket that takes many datagrams a system call.
#pragma once

#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "robotskin/datagram.h"

namespace robotskin::driver {

struct Address {
  sockaddr_storage storage{};
  socklen_t length = 0;

  // Throws std::invalid_argument for a host that cannot be resolved.
  static Address resolve(const std::string& host, std::uint16_t port, int family = AF_UNSPEC);

  std::string host() const;
  std::uint16_t port() const;
};

class UdpSocket {
 public:
  static constexpr std::size_t batch = 64;  // datagrams a system call

  // Binds to `local` (port 0: any free one); asks for `buffer_bytes` of receive buffer and takes what it gets.
  // Throws std::system_error.
  UdpSocket(const Address& local, int buffer_bytes);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  Address local() const;
  int descriptor() const { return descriptor_; }  // to be waited for with others

  // Takes what has arrived, at most `batch`; 0 if nothing has. The datagrams stay until the next call.
  std::size_t receive();
  std::span<const std::uint8_t> datagram(std::size_t i) const { return {bytes_[i].data(), messages_[i].msg_len}; }
  Address sender(std::size_t i) const;

  // Waits until a datagram is there, at most `timeout_ns`.
  void wait(std::int64_t timeout_ns) const;

  // Whether the system took it; a datagram may always be lost.
  bool send(std::span<const std::uint8_t> datagram, const Address& to) const;

  // Sends all, many a system call; how many the system took.
  std::size_t send_many(std::span<mmsghdr> messages) const;

  // Datagrams that the system dropped because the receive buffer was full.
  std::uint64_t dropped() const;
  int buffer_bytes() const;

 private:
  // One byte more than a datagram may have, so that one that is too long shows.
  using Bytes = std::array<std::uint8_t, RS_DATAGRAM_BYTES_MAX + 1>;

  int descriptor_ = -1;
  std::vector<Bytes> bytes_;
  std::vector<sockaddr_storage> senders_;
  std::vector<iovec> vectors_;
  std::vector<mmsghdr> messages_;
};

}  // namespace robotskin::driver
