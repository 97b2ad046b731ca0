// SPDX-License-Identifier: Apache-2.0
#include "world/random.hpp"

#include <cmath>
#include <numbers>

namespace robotskin::world {
namespace {

double normal_cdf(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

std::array<float, 1U << normal_bits> make_normal_quantiles() {
  std::array<float, 1U << normal_bits> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(table.size());
    double low = -5, high = 5;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (low + high);
      (normal_cdf(middle) < share ? low : high) = middle;
    }
    table[i] = static_cast<float>(0.5 * (low + high));
  }
  return table;
}

}  // namespace

const std::array<float, 1U << normal_bits>& normal_quantiles() {
  static const std::array<float, 1U << normal_bits> table = make_normal_quantiles();
  return table;
}

}  // namespace robotskin::world
