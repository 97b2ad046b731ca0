// Runs the skin cycle through touches, switches and faults; prints its allocations and times as JSON.
// Arguments: URDF, seed.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <vector>

#include "../count_allocations.hpp"
#include "random_skin.hpp"
#include "robot/skin_cycle.hpp"

using namespace robotskin;

namespace {

constexpr int cycles = 10000;

robot::CycleGains gains(std::size_t n) {
  robot::CycleGains result;
  result.joint = {std::vector<double>(n, 1000), std::vector<double>(n, 0)};
  result.skin = control::SkinGains::uniform(cells, 20, 10, 0.3F, 0.9F, 0.02F, 0.05F);
  result.resolver.virtual_robot = {std::vector<double>(n, 0.2), std::vector<double>(n, 400)};
  result.resolver.inner_loop.proportional.assign(n, 10);
  result.resolver.inner_loop.integral.assign(n, 25);
  result.resolver.inner_loop.derivative.assign(n, 0.1);
  result.skin_bandwidth_hz = 80;
  return result;
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count != 3) return 2;
  std::ostringstream text;
  text << std::ifstream(arguments[1]).rdbuf();
  std::mt19937_64 generator(std::strtoull(arguments[2], nullptr, 10));
  const RobotModel robot(text.str());
  const std::size_t n = robot.joint_count();
  robot::GuardLimits limits;
  limits.acceleration.assign(n, 100);
  limits.stop_deceleration.assign(n, 10);
  limits.torque_rate.assign(n, 1e4);
  robot::SkinCycle cycle(robot, random_skin(robot, generator), gains(n), limits);

  JointState joints(n);
  skin::SkinState skin;
  skin.resize(cells);
  std::ranges::fill(skin.health, skin::Health::alive);
  JointCommand command(CommandMode::position, n);
  std::uniform_real_distribution<float> force(0, 3);
  std::vector<double> goal(n, 0.1), cycle_us(cycles);
  std::uint64_t visited = 0;
  long allocations = 0;
  for (int i = 0; i < cycles; ++i) {
    const std::int64_t now_ns = 1'000'000'000 + i * std::int64_t{1'000'000};
    joints.stamp_ns = skin.time_ns = now_ns;
    // Once in a while the joints, or the skin, are silent long enough to stop the robot.
    if (i % 2000 > 1850 && i % 2000 < 1900) joints.stamp_ns = now_ns - 1'000'000'000;
    if (i % 3000 > 2800) skin.time_ns = now_ns - 1'000'000'000;
    std::fill_n(skin.health.begin(), 60, i % 2500 > 2300 ? skin::Health::stale : skin::Health::alive);
    skin.normal_force[generator() % cells] = {force(generator), force(generator), force(generator)};
    if (i == 7777) joints.position[0] = std::numeric_limits<double>::quiet_NaN();
    allocations += allocations_of([&] {
      cycle.request_run(i % 2000 < 1950);
      cycle.request_mode(static_cast<CommandMode>(i / 700 % 3));
      cycle.request_skin_task(i % 900 < 600);
      (void)cycle.request_patch_mask(i % 3, i % 500 < 250);
      (void)cycle.request_goal(goal);
      const auto start = std::chrono::steady_clock::now();
      visited |= std::uint64_t{1} << static_cast<int>(cycle.step(joints, skin, now_ns, command).state);
      cycle_us[i] = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
    });
    if (i == 7777) joints.position[0] = 0;
    if (command.mode == CommandMode::position) joints.position = command.value;
    for (double& position : joints.position)
      if (!std::isfinite(position)) position = 0;
  }
  std::ranges::sort(cycle_us);
  const long counted = allocations_of([] { std::make_unique<std::vector<double>>(100); });
  std::printf("{\"allocations\": %ld, \"counted_of_two\": %ld, \"states_visited\": %d, ", allocations, counted,
              static_cast<int>(visited));
  std::printf("\"cycle_median_us\": %.2f, \"cycle_p99_us\": %.2f, \"cycle_worst_us\": %.2f}\n", cycle_us[cycles / 2],
              cycle_us[cycles * 99 / 100], cycle_us.back());
}
