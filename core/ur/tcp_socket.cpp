// SPDX-License-Identifier: Apache-2.0
#include "ur/tcp_socket.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <utility>

#include "ur/ur_error.hpp"

namespace robotskin::ur {
namespace {

constexpr std::size_t line_bytes_max = 4096;

int milliseconds(double seconds) {
  return static_cast<int>(seconds * 1000) + 1;
}

bool ready(int descriptor, short what, double within_s) noexcept {
  pollfd one{descriptor, what, 0};
  return poll(&one, 1, milliseconds(within_s)) > 0;
}

// An open connection, or -1 with errno.
int connected(const addrinfo& address, double within_s) {
  const int descriptor = socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0) return -1;
  int error = connect(descriptor, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (error == EINPROGRESS) {
    error = ETIMEDOUT;
    socklen_t size = sizeof error;
    if (ready(descriptor, POLLOUT, within_s)) getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
  }
  if (error != 0) {
    close(descriptor);
    errno = error;
    return -1;
  }
  const int yes = 1;
  setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  return descriptor;
}

}  // namespace

TcpSocket::TcpSocket(const std::string& host, std::uint16_t port, double within_s)
    : told_(host + ":" + std::to_string(port)) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (error != 0) throw UrError("robot " + told_ + ": " + gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, &freeaddrinfo);
  for (const addrinfo* one = found; one != nullptr && descriptor_ < 0; one = one->ai_next)
    descriptor_ = connected(*one, within_s);
  if (descriptor_ < 0) throw UrError("robot " + told_ + ": " + std::strerror(errno));
}

TcpSocket::TcpSocket(TcpSocket&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      told_(std::move(other.told_)),
      pending_(std::move(other.pending_)) {}

TcpSocket& TcpSocket::operator=(TcpSocket&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(told_, other.told_);
  std::swap(pending_, other.pending_);
  return *this;
}

void TcpSocket::close() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

bool TcpSocket::send(std::span<const std::uint8_t> bytes, double within_s) const noexcept {
  while (!bytes.empty()) {
    const ssize_t taken = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (taken > 0)
      bytes = bytes.subspan(static_cast<std::size_t>(taken));
    else if ((errno != EAGAIN && errno != EINTR) || !ready(descriptor_, POLLOUT, within_s))
      return false;
  }
  return true;
}

bool TcpSocket::send(std::string_view text, double within_s) const noexcept {
  return send({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, within_s);
}

int TcpSocket::receive(std::span<std::uint8_t> bytes) const noexcept {
  const ssize_t count = recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count > 0) return static_cast<int>(count);
  return count < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : -1;
}

bool TcpSocket::wait(double within_s) const noexcept {
  return ready(descriptor_, POLLIN, within_s);
}

std::string TcpSocket::line(double within_s) {
  using Clock = std::chrono::steady_clock;
  const auto ends = Clock::now() + std::chrono::duration<double>(within_s);
  for (;;) {
    if (const std::size_t end = pending_.find('\n'); end != std::string::npos) {
      std::string found = pending_.substr(0, end);
      pending_.erase(0, end + 1);
      if (!found.empty() && found.back() == '\r') found.pop_back();
      return found;
    }
    const double left_s = std::chrono::duration<double>(ends - Clock::now()).count();
    std::array<std::uint8_t, 512> bytes;
    const int count = left_s > 0 && wait(left_s) ? receive(bytes) : -1;
    if (count < 0 || pending_.size() > line_bytes_max)
      throw UrError("robot " + told_ + ": no answer within " + std::to_string(within_s).substr(0, 4) + " s");
    pending_.append(reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(count));
  }
}

}  // namespace robotskin::ur
