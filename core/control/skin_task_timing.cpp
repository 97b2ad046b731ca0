#include "control/skin_task_timing.hpp"

#include <chrono>

#include "control/wrench_product.hpp"

namespace robotskin::control {
namespace {

template <typename Work>
void measure(std::vector<std::int64_t>& times, const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  times.push_back(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace

SkinTaskTimes time_skin_task(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains,
                             const skin::SkinState& state, const skin::SkinState& other,
                             std::span<const double> position, std::size_t rounds) {
  SkinTask task(robot, skin, gains);
  NaiveSkinTask naive(robot, skin);
  RobotDynamics dynamics(robot);
  const std::vector<double> at_rest(robot.joint_count());
  const std::vector<float> share(skin.size(), 1.0F);
  std::vector<double> torque(robot.joint_count());
  // The bare product of all cells as if they were on one body.
  const std::vector<double> matrix(6 * skin.size(), 0.5), force(skin.size(), 1.0);
  std::vector<double> wrench(6);

  SkinTaskTimes times;
  for (auto* values : {&times.product, &times.task, &times.kinematics, &times.naive}) values->reserve(rounds);
  bool computed = true;
  for (std::size_t round = 0; round < rounds; ++round) {
    const skin::SkinState& current = round % 2 == 0 ? state : other;
    measure(times.kinematics, [&] { computed = dynamics.update(position, at_rest) && computed; });
    measure(times.task, [&] { computed = task.compute(dynamics, current, share, torque) && computed; });
    computed = dynamics.update(position, at_rest) && computed;  // so that the product finds the caches as the task did
    measure(times.product,
            [&] { wrench_product(matrix.data(), skin.size(), force.data(), skin.size(), wrench.data()); });
    if (round % 10 == 0) measure(times.naive, [&] { naive.compute(dynamics, task.magnitudes(), torque); });
  }
  return computed ? times : SkinTaskTimes{};
}

}  // namespace robotskin::control
