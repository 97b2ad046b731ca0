// SPDX-License-Identifier: Apache-2.0
#include "campaign/touch_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "robotskin/channels.h"
#include "robotskin/crc.h"

namespace robotskin::campaign {
namespace {

using Vector = std::array<double, 3>;

constexpr double unit = 1 << RS_UNIT_BITS, matrix = 1 << RS_MATRIX_BITS, length = 1 << RS_LENGTH_BITS;
constexpr double relative_error = 0.005;  // of the longest lever
constexpr double reach = 1.8;             // units of length

double between(world::RandomStream& draw, double low, double high) {
  return low + (high - low) * static_cast<double>(draw.below(1U << 20)) / (1U << 20);
}

std::int16_t coded(double value, double one, int greatest) {
  return static_cast<std::int16_t>(std::clamp(std::lround(value * one), -std::lround(greatest), std::lround(greatest)));
}

std::uint16_t number(world::RandomStream& draw, std::uint64_t low, std::uint64_t high) {
  return static_cast<std::uint16_t>(low + draw.below(high - low + 1));
}

// A turn drawn by a unit quaternion.
std::array<std::int16_t, 9> drawn_rotation(world::RandomStream& draw) {
  std::array<double, 4> q{};
  double square = 0;
  for (double& one : q) {
    one = between(draw, -1, 1);
    square += one * one;
  }
  for (double& one : q) one /= std::sqrt(std::max(square, 1e-9));
  const auto [w, x, y, z] = q;
  const std::array<double, 9> turn{1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                                   2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                                   2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  std::array<std::int16_t, 9> rotation{};
  for (std::size_t i = 0; i < 9; ++i) rotation[i] = coded(turn[i], matrix, 1 << RS_MATRIX_BITS);
  return rotation;
}

std::array<std::int16_t, 3> drawn_offset(world::RandomStream& draw) {
  std::array<std::int16_t, 3> offset{};
  for (std::int16_t& one : offset) one = coded(between(draw, -0.08, 0.08), length, INT16_MAX);
  return offset;
}

Vector decoded(const std::array<std::int16_t, 3>& numbers, double one) {
  return {numbers[0] / one, numbers[1] / one, numbers[2] / one};
}

Vector lowered(const Vector& vector, const std::array<std::int16_t, 9>& rotation, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Vector turned{c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]};
  Vector result{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      result[row] += rotation[3 * row + column] / matrix * turned[column];
  return result;
}

}  // namespace

TouchModel::TouchModel(world::RandomStream& draw, int step_bits)
    : joints_(1 + draw.below(joints_max)),
      step_bits_(step_bits),
      length_exponent_(static_cast<int>(draw.below(3)) - 1),
      prismatic_(static_cast<std::uint16_t>(draw.below(4) == 0 ? draw.below(1U << joints_) : 0)),
      slide_(static_cast<std::uint16_t>(0.05 * length)),
      point_(drawn_offset(draw)),
      direction_{},
      place_{},
      force_{number(draw, 0, 800), number(draw, 900, 2500), number(draw, 1, 16), 14},
      proximity_{number(draw, 0, 20), number(draw, 30, 200), number(draw, 1, 64), 12} {
  const auto rotation = drawn_rotation(draw);
  for (std::size_t i = 0; i < 3; ++i) direction_[i] = coded(rotation[6 + i] / matrix, INT16_MAX, INT16_MAX);
  for (Place& place : place_) place = {drawn_rotation(draw), drawn_offset(draw)};
}

std::array<std::uint8_t, RS_TORQUE_IMAGE_BYTES> TouchModel::image() const {
  std::vector<std::uint8_t> bytes{1,
                                  0,
                                  static_cast<std::uint8_t>(joints_),
                                  static_cast<std::uint8_t>(length_exponent_),
                                  static_cast<std::uint8_t>(step_bits_),
                                  0};
  const auto put = [&](int value) {
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
    bytes.push_back(static_cast<std::uint8_t>(value));
  };
  const auto put_sense = [&](const Sense& sense) {
    put(sense.silent);
    put(sense.full);
    put(sense.weight);
  };
  put(prismatic_);
  put(slide_);
  for (const int one : point_) put(one);
  for (const int one : direction_) put(one);
  put_sense(force_);
  bytes.push_back(force_.weight_bits);
  bytes.push_back(proximity_.weight_bits);
  put_sense(proximity_);
  for (std::size_t l = 0; l + 1 < joints_; ++l) {
    for (const int one : place_[l].rotation) put(one);
    for (const int one : place_[l].offset) put(one);
  }
  const std::uint16_t checksum = rs_crc16(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  std::array<std::uint8_t, RS_TORQUE_IMAGE_BYTES> image{};
  std::ranges::copy(bytes, image.begin());
  image[RS_TORQUE_CHECKSUM_AT] = static_cast<std::uint8_t>(checksum >> 8);
  image[RS_TORQUE_CHECKSUM_AT + 1] = static_cast<std::uint8_t>(checksum);
  return image;
}

double TouchModel::Sense::asked(double counts) const {
  const double x = std::clamp((counts - silent) / (full - silent), 0.0, 1.0);
  return counts * x * x * (3 - 2 * x) * std::ldexp(weight, -weight_bits);
}

double TouchModel::force(const rs_sample& sample) const {
  double felt = 0;
  for (int channel = RS_CHANNEL_force_1; channel <= RS_CHANNEL_force_3; ++channel)
    felt += std::max(sample.value[channel], 0);
  return force_.asked(felt) + proximity_.asked(std::max(sample.value[RS_CHANNEL_proximity], 0));
}

TouchModel::Torques TouchModel::torques(double force, std::span<const std::int16_t> position) const {
  const double metre = std::ldexp(1.0, length_exponent_), steps = std::ldexp(force, step_bits_);
  Vector point = decoded(point_, length), direction = decoded(direction_, unit);
  Torques torques{};
  for (std::size_t l = joints_; l-- > 0;) {
    double angle = 0;
    if ((prismatic_ >> l & 1) != 0) {
      torques[l] = steps * direction[2];
      point[2] += std::clamp<int>(position[l], -slide_, slide_) / length / metre;
    } else {
      torques[l] = steps * metre * (point[0] * direction[1] - point[1] * direction[0]);
      angle = 2 * std::numbers::pi * position[l] / RS_TURN;
    }
    if (l == 0) break;
    const Place& place = place_[l - 1];
    direction = lowered(direction, place.rotation, angle);
    const Vector offset = decoded(place.offset, length);
    point = lowered(point, place.rotation, angle);
    for (std::size_t i = 0; i < 3; ++i) point[i] += offset[i];
  }
  return torques;
}

double TouchModel::tolerance(double force) const {
  return 1 + relative_error * reach * 2 * std::ldexp(force, step_bits_);
}

}  // namespace robotskin::campaign
