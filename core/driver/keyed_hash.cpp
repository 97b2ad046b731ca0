// SPDX-License-Identifier: Apache-2.0
#include "driver/keyed_hash.hpp"

#include <algorithm>

namespace robotskin::driver {

Tag KeyedHash::tag(std::span<const std::uint8_t> bytes) const {
  boost::hash2::blake2s_256 hash = start_;
  hash.update(bytes.data(), bytes.size());
  const auto digest = hash.result();
  Tag tag;
  std::copy_n(digest.begin(), tag.size(), tag.begin());
  return tag;
}

bool KeyedHash::matches(std::span<const std::uint8_t> bytes, const std::uint8_t* given) const {
  const Tag right = tag(bytes);
  std::uint8_t difference = 0;
  for (std::size_t i = 0; i < right.size(); ++i) difference |= static_cast<std::uint8_t>(right[i] ^ given[i]);
  return difference == 0;
}

void KeyedHash::hook(void* context, const std::uint8_t* bytes, std::uint32_t count, std::uint8_t* tag) {
  const Tag right = static_cast<const KeyedHash*>(context)->tag({bytes, count});
  std::copy(right.begin(), right.end(), tag);
}

}  // namespace robotskin::driver
