// SPDX-License-Identifier: Apache-2.0
// The tag of a datagram: keyed BLAKE2s-256 (RFC 7693), of which the first 16 bytes are sent.
#pragma once

#include <array>
#include <boost/hash2/blake2.hpp>
#include <cstdint>
#include <span>

#include "robotskin/datagram.h"

namespace robotskin::driver {

using Key = std::array<std::uint8_t, RS_DATAGRAM_KEY_BYTES>;
using Tag = std::array<std::uint8_t, RS_DATAGRAM_TAG_BYTES>;

class KeyedHash {
 public:
  explicit KeyedHash(const Key& key) : start_(key.data(), key.size()) {}

  Tag tag(std::span<const std::uint8_t> bytes) const;

  // Compares without a branch on what is secret, so that time tells nothing about the right tag.
  bool matches(std::span<const std::uint8_t> bytes, const std::uint8_t* tag) const;

  // The hook of section_unit.h (rs_tag_hook): `context` is a const KeyedHash*.
  static void hook(void* context, const std::uint8_t* bytes, std::uint32_t count, std::uint8_t* tag);

 private:
  boost::hash2::blake2s_256 start_;  // has taken the key block in
};

}  // namespace robotskin::driver
