// SPDX-License-Identifier: Apache-2.0
// Runs the dynamics of a robot many times; prints allocations and times of a cycle as JSON. Arguments: URDF, seed.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <vector>

#include "../count_allocations.hpp"
#include "model/robot_dynamics.hpp"

int main(int argument_count, char** arguments) {
  if (argument_count != 3) return 2;
  std::ostringstream text;
  text << std::ifstream(arguments[1]).rdbuf();
  const robotskin::RobotModel model(text.str());
  robotskin::RobotDynamics dynamics(model);
  const std::size_t n = model.joint_count();
  std::vector<double> q(n), v(n), torque(n), acceleration(n), jacobian(6 * n), placement(16);
  std::mt19937_64 generator(std::strtoull(arguments[2], nullptr, 10));
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);

  long allocations = 0;
  bool accepted = true;
  std::vector<double> update_us(2000);
  for (double& time_us : update_us) {
    for (std::size_t joint = 0; joint < n; ++joint) {
      q[joint] = uniform(generator);
      v[joint] = uniform(generator);
      torque[joint] = uniform(generator);
    }
    allocations += allocations_of([&] {
      const auto start = std::chrono::steady_clock::now();
      accepted &= dynamics.update(q, v);
      time_us = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
      accepted &= dynamics.forward_dynamics(torque, acceleration);
      accepted &= dynamics.solve_mass(torque, acceleration);
      for (std::size_t link = 0; link < model.link_count(); ++link) {
        accepted &= dynamics.base_from_link(link, placement) && dynamics.link_jacobian(link, jacobian);
      }
    });
  }
  std::sort(update_us.begin(), update_us.end());
  const long counted = allocations_of([] { std::make_unique<std::vector<double>>(100); });
  std::printf("{\"accepted\": %s, \"allocations\": %ld, \"counted_of_two\": %ld, ", accepted ? "true" : "false",
              allocations, counted);
  std::printf("\"update_median_us\": %.2f, \"update_worst_us\": %.2f}\n", update_us[update_us.size() / 2],
              update_us.back());
}
