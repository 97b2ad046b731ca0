// SPDX-License-Identifier: Apache-2.0
// Chaskey-12 as it was published (Mouha et al. 2014; ISO/IEC 29192-6): the checkers' own, so that tags and keys are
// judged by another program than the one that made them.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace robotskin::campaign {

using MacBytes = std::array<std::uint8_t, 16>;  // a key, or a tag

namespace published {

using State = std::array<std::uint32_t, 4>;

inline void permute(State& v) {
  for (int round = 0; round < 12; ++round) {
    v[0] += v[1], v[1] = std::rotl(v[1], 5) ^ v[0], v[0] = std::rotl(v[0], 16);
    v[2] += v[3], v[3] = std::rotl(v[3], 8) ^ v[2];
    v[0] += v[3], v[3] = std::rotl(v[3], 13) ^ v[0];
    v[2] += v[1], v[1] = std::rotl(v[1], 7) ^ v[2], v[2] = std::rotl(v[2], 16);
  }
}

// By x in GF(2^128), modulo x^128 + x^7 + x^2 + x + 1.
inline State times_x(const State& v) {
  State product;
  for (std::size_t i = 0; i < 4; ++i) product[i] = v[i] << 1 | (i == 0 ? 0 : v[i - 1] >> 31);
  if (v[3] >> 31 != 0) product[0] ^= 0x87;
  return product;
}

inline void add(State& v, std::size_t at, std::uint8_t byte) {
  v[at / 4] ^= static_cast<std::uint32_t>(byte) << 8 * (at % 4);
}

}  // namespace published

inline MacBytes published_mac(const MacBytes& key, std::span<const std::uint8_t> message) {
  published::State whole{};
  for (std::size_t i = 0; i < key.size(); ++i) published::add(whole, i, key[i]);
  published::State v = whole;
  while (message.size() > 16) {
    for (std::size_t i = 0; i < 16; ++i) published::add(v, i, message[i]);
    published::permute(v);
    message = message.subspan(16);
  }
  published::State last = published::times_x(whole);
  for (std::size_t i = 0; i < message.size(); ++i) published::add(v, i, message[i]);
  if (message.size() < 16) {
    last = published::times_x(last);
    published::add(v, message.size(), 1);
  }
  for (std::size_t i = 0; i < 4; ++i) v[i] ^= last[i];
  published::permute(v);
  MacBytes tag;
  for (std::size_t i = 0; i < 16; ++i) tag[i] = static_cast<std::uint8_t>((v[i / 4] ^ last[i / 4]) >> 8 * (i % 4));
  return tag;
}

}  // namespace robotskin::campaign
