// SPDX-License-Identifier: Apache-2.0
// Randomness as an argument: numbers that depend on nothing but seed, stream and counter, so that the order in which
// they are drawn changes nothing and one seed repeats a whole run.
#pragma once

#include <array>
#include <cstdint>

namespace robotskin::world {

// SplitMix64's finaliser: a bijection of 64 bits in which every input bit moves every output bit.
constexpr std::uint64_t scramble(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xBF58476D1CE4E5B9U;
  x ^= x >> 27;
  x *= 0x94D049BB133111EBU;
  return x ^ (x >> 31);
}

// Names one sequence of random numbers of a run: what draws (a cell, a link) and what for.
constexpr std::uint64_t stream_family(std::uint64_t seed, std::uint64_t purpose) {
  return scramble(scramble(seed + 0x9E3779B97F4A7C15U) + purpose);
}
constexpr std::uint64_t stream_key(std::uint64_t seed, std::uint64_t purpose, std::uint64_t index) {
  return scramble(stream_family(seed, purpose) + index);
}

constexpr std::uint64_t random_bits(std::uint64_t key, std::uint64_t counter) {
  return scramble(key + (counter + 1) * 0x9E3779B97F4A7C15U);
}

// In [0, 1).
constexpr double random_unit(std::uint64_t key, std::uint64_t counter) {
  return static_cast<double>(random_bits(key, counter) >> 11) * 0x1p-53;
}

// In [-half_width, half_width).
constexpr double random_symmetric(std::uint64_t key, std::uint64_t counter, double half_width) {
  return (2 * random_unit(key, counter) - 1) * half_width;
}

// One sequence drawn in order.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t key) : key_(key) {}
  std::uint64_t bits() { return random_bits(key_, counter_++); }
  std::uint64_t below(std::uint64_t limit) { return bits() % limit; }

 private:
  std::uint64_t key_, counter_ = 0;
};

// Quantiles of the standard normal distribution at (i + 1/2) / 4096: a draw of 12 bits is one look-up.
inline constexpr int normal_bits = 12;
const std::array<float, 1U << normal_bits>& normal_quantiles();

}  // namespace robotskin::world
