// SPDX-License-Identifier: Apache-2.0
// Packages of the Real-Time Data Exchange, protocol version 2: big-endian, a size of 16 bits, a kind of 8 bits, a body.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace robotskin::ur::rtde {

inline constexpr std::uint16_t protocol_version = 2;
inline constexpr std::size_t header_bytes = 3;
inline constexpr std::size_t package_bytes_max = 2048;  // ours are far smaller; more is no answer to what we ask

enum class Kind : std::uint8_t {
  protocol_version = 'V',
  controller_version = 'v',
  text = 'M',
  outputs = 'O',
  inputs = 'I',
  start = 'S',
  pause = 'P',
  data = 'U',
};

// Reads a body from its beginning; what is beyond its end reads as 0 and is told by `whole`.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  template <typename Whole>
  Whole number() noexcept {
    Whole value = 0;
    if (bytes_.size() - at_ < sizeof(Whole)) {
      whole_ = false;
      at_ = bytes_.size();
      return 0;
    }
    for (std::size_t i = 0; i < sizeof(Whole); ++i) value = static_cast<Whole>((value << 7 << 1) | bytes_[at_++]);
    return value;
  }
  double real() noexcept { return std::bit_cast<double>(number<std::uint64_t>()); }
  std::string_view rest() const noexcept {
    return {reinterpret_cast<const char*>(bytes_.data()) + at_, bytes_.size() - at_};
  }
  bool whole() const noexcept { return whole_; }
  bool ended() const noexcept { return whole_ && at_ == bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool whole_ = true;
};

// Builds one package in place; `bytes` holds until the next `begin`.
class Writer {
 public:
  Writer& begin(Kind kind) noexcept {
    size_ = header_bytes;
    bytes_[2] = static_cast<std::uint8_t>(kind);
    return *this;
  }
  template <typename Whole>
  Writer& number(Whole value) noexcept {
    for (std::size_t i = sizeof(Whole); i-- > 0;) put(static_cast<std::uint8_t>(value >> (8 * i)));
    return *this;
  }
  Writer& real(double value) noexcept { return number(std::bit_cast<std::uint64_t>(value)); }
  Writer& text(std::string_view value) noexcept {
    for (const char one : value) put(static_cast<std::uint8_t>(one));
    return *this;
  }
  std::span<const std::uint8_t> bytes() noexcept {
    bytes_[0] = static_cast<std::uint8_t>(size_ >> 8);
    bytes_[1] = static_cast<std::uint8_t>(size_);
    return {bytes_.data(), size_};
  }

 private:
  void put(std::uint8_t byte) noexcept {
    if (size_ < bytes_.size()) bytes_[size_++] = byte;
  }

  std::array<std::uint8_t, package_bytes_max> bytes_{};
  std::size_t size_ = header_bytes;
};

struct Package {
  Kind kind{};
  std::span<const std::uint8_t> body;
};

// Cuts a stream of bytes into packages.
class Splitter {
 public:
  // Where the next bytes of the stream go, and how many have arrived there.
  std::span<std::uint8_t> room() noexcept;
  void arrived(std::size_t count) noexcept { end_ += count; }
  // The next whole package; it holds until the next call of `room`. False: there is none yet.
  bool next(Package& package) noexcept;
  // A size that cannot be was read: the stream is lost.
  bool broken() const noexcept { return broken_; }
  void clear() noexcept { begin_ = end_ = 0, broken_ = false; }

 private:
  std::array<std::uint8_t, 4 * package_bytes_max> bytes_{};
  std::size_t begin_ = 0, end_ = 0;
  bool broken_ = false;
};

}  // namespace robotskin::ur::rtde
