// SPDX-License-Identifier: Apache-2.0
#include "driver/udp_socket.hpp"

#include <linux/sock_diag.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace robotskin::driver {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

Address Address::resolve(const std::string& host, std::uint16_t port, int family) {
  addrinfo hints{};
  hints.ai_family = family;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (error != 0) throw std::invalid_argument("host '" + host + "' cannot be resolved: " + gai_strerror(error));
  Address address;
  std::copy_n(reinterpret_cast<const char*>(found->ai_addr), found->ai_addrlen,
              reinterpret_cast<char*>(&address.storage));
  address.length = found->ai_addrlen;
  freeaddrinfo(found);
  return address;
}

std::string Address::host() const {
  char text[NI_MAXHOST] = "";
  getnameinfo(reinterpret_cast<const sockaddr*>(&storage), length, text, sizeof text, nullptr, 0, NI_NUMERICHOST);
  return text;
}

std::uint16_t Address::port() const {
  if (storage.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6&>(storage).sin6_port);
  return ntohs(reinterpret_cast<const sockaddr_in&>(storage).sin_port);
}

UdpSocket::UdpSocket(const Address& local, int buffer_bytes)
    : bytes_(batch), senders_(batch), vectors_(batch), messages_(batch) {
  descriptor_ = socket(local.storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor_ < 0) fail("socket");
  // A privileged process may pass the system's limit; others get what the limit allows.
  if (setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUFFORCE, &buffer_bytes, sizeof buffer_bytes) != 0) {
    setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof buffer_bytes);
  }
  if (bind(descriptor_, reinterpret_cast<const sockaddr*>(&local.storage), local.length) != 0) {
    const int error = errno;
    close(descriptor_);
    errno = error;
    fail("cannot bind UDP " + local.host() + " port " + std::to_string(local.port()));
  }
  for (std::size_t i = 0; i < batch; ++i) {
    vectors_[i] = {bytes_[i].data(), bytes_[i].size()};
    messages_[i].msg_hdr.msg_iov = &vectors_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
    messages_[i].msg_hdr.msg_name = &senders_[i];
  }
}

UdpSocket::~UdpSocket() {
  close(descriptor_);
}

Address UdpSocket::local() const {
  Address address;
  address.length = sizeof address.storage;
  getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address.storage), &address.length);
  return address;
}

std::size_t UdpSocket::receive() {
  for (mmsghdr& message : messages_) message.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
  const int count = recvmmsg(descriptor_, messages_.data(), batch, MSG_DONTWAIT, nullptr);
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

Address UdpSocket::sender(std::size_t i) const {
  return {senders_[i], messages_[i].msg_hdr.msg_namelen};
}

void UdpSocket::wait(std::int64_t timeout_ns) const {
  pollfd descriptor{descriptor_, POLLIN, 0};
  const timespec timeout{timeout_ns / 1'000'000'000, timeout_ns % 1'000'000'000};
  ppoll(&descriptor, 1, &timeout, nullptr);
}

bool UdpSocket::send(std::span<const std::uint8_t> datagram, const Address& to) const {
  return sendto(descriptor_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                reinterpret_cast<const sockaddr*>(&to.storage), to.length) >= 0;
}

std::size_t UdpSocket::send_many(std::span<mmsghdr> messages) const {
  std::size_t sent = 0;
  while (sent < messages.size()) {
    const std::size_t count = std::min<std::size_t>(messages.size() - sent, 1024);
    const int taken = sendmmsg(descriptor_, &messages[sent], static_cast<unsigned>(count), MSG_NOSIGNAL);
    if (taken <= 0) break;
    sent += static_cast<std::size_t>(taken);
  }
  return sent;
}

std::uint64_t UdpSocket::dropped() const {
  std::uint32_t info[SK_MEMINFO_VARS] = {};
  socklen_t bytes = sizeof info;
  getsockopt(descriptor_, SOL_SOCKET, SO_MEMINFO, info, &bytes);
  return info[SK_MEMINFO_DROPS];
}

int UdpSocket::buffer_bytes() const {
  int bytes = 0;
  socklen_t size = sizeof bytes;
  getsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &bytes, &size);
  return bytes;
}

}  // namespace robotskin::driver
