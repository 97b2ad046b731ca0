// Fusion of tasks by weights (eq. 18).
#pragma once

#include <cstddef>
#include <initializer_list>
#include <span>

namespace robotskin::control {

struct WeightedTorque {
  double weight;                   // w_k, 1: as the task asks
  std::span<const double> torque;  // (n) tau_k, Nm
};

// fused (n) = sum of w_k tau_k (eq. 18), Nm.
inline void weighted_fusion(std::initializer_list<WeightedTorque> tasks, std::span<double> fused) noexcept {
  for (std::size_t i = 0; i < fused.size(); ++i) {
    double sum = 0;
    for (const WeightedTorque& task : tasks) sum += task.weight * task.torque[i];
    fused[i] = sum;
  }
}

}  // namespace robotskin::control
