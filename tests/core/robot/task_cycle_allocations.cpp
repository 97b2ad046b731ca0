// SPDX-License-Identifier: Apache-2.0
// Runs the task cycle with every task and fusion of the library, through touches and switches of stacks; prints its
// allocations as JSON. Arguments: URDF, seed.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <random>
#include <sstream>
#include <vector>

#include "../count_allocations.hpp"
#include "control/cartesian_task.hpp"
#include "control/contact_impedance_task.hpp"
#include "control/gravity_task.hpp"
#include "control/joint_limit_task.hpp"
#include "control/joint_task.hpp"
#include "control/map_skin_task.hpp"
#include "control/propagated_compliance_task.hpp"
#include "control/skin_cartesian_task.hpp"
#include "control/skin_reaction_task.hpp"
#include "control/spline_cartesian_task.hpp"
#include "control/spline_joint_task.hpp"
#include "random_skin.hpp"
#include "robot/task_cycle.hpp"

using namespace robotskin;

namespace {

constexpr int cycles = 6000;

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count != 3) return 2;
  std::ostringstream text;
  text << std::ifstream(arguments[1]).rdbuf();
  std::mt19937_64 generator(std::strtoull(arguments[2], nullptr, 10));
  const RobotModel robot(text.str());
  const std::size_t n = robot.joint_count();
  const skin::SkinModel model = random_skin(robot, generator);
  const auto skin_gains = control::SkinGains::uniform(cells, 20, 10, 0.3F, 0.9F, 0.02F, 0.05F);

  std::size_t last_link = 0;
  for (std::size_t link = 0; link < robot.link_count(); ++link)
    if (robot.link_joints()[link] == static_cast<int>(n) - 1) last_link = link;
  const std::string hand = robot.link_names()[last_link];
  const control::JointGains joint_gains{std::vector<double>(n, 100), std::vector<double>(n, 5)};
  const control::CartesianGains pose_gains{{500, 500, 500, 20, 20, 20}, {20, 20, 20, 1, 1, 1}};
  const auto gravity = std::make_shared<control::GravityTask>(n);
  const auto posture = std::make_shared<control::JointTask>(robot, joint_gains);
  const auto spline = std::make_shared<control::SplineJointTask>(robot, joint_gains, 0.5);
  const auto pose = std::make_shared<control::CartesianTask>(robot, hand, pose_gains);
  const auto path = std::make_shared<control::SplineCartesianTask>(robot, hand, pose_gains, 0.2, 1.0);
  const auto limit = std::make_shared<control::JointLimitTask>(robot, control::JointLimitGains{});
  const auto felt = std::make_shared<control::TouchWrench>(robot, model, skin_gains);
  const auto touch = std::make_shared<control::SkinReactionTask>(felt, 80);
  const auto drag = std::make_shared<control::SkinCartesianTask>(robot, felt, hand, 80);
  const auto contact = std::make_shared<control::ContactImpedanceTask>(felt, control::ContactImpedanceGains{});
  control::SkinMap map{std::vector<double>(2 * n, 0.0), std::vector<double>(2 * cells * n, 0.1)};
  for (std::size_t i = n; i < 2 * n; ++i) map.posture[i] = 0.2;
  const auto recalled = std::make_shared<control::MapSkinTask>(n, cells, skin_gains, map, 0.3);

  std::vector<control::Limb> limbs = {{.name = "base"}, {.name = "rest", .parent = "base"}};
  for (std::size_t i = 0; i < n; ++i) {
    control::Limb& limb = limbs[i < n / 2 ? 0 : 1];
    limb.joints.push_back(robot.joint_names()[i]);
    limb.largest_acceleration.push_back(15);
  }
  const auto whole =
      std::make_shared<control::PropagatedComplianceTask>(robot, model, felt, limbs, control::PropagationGains{});

  const std::vector<control::StackEntry> entries = {{gravity, control::StackEntry::feedforward},
                                                    {limit, 0},
                                                    {pose, 1},
                                                    {touch, 2},
                                                    {recalled, 2},
                                                    {contact, 3},
                                                    {whole, 3},
                                                    {drag, 3},
                                                    {path, 4},
                                                    {spline, 5},
                                                    {posture, 5}};
  auto tight = control::QuadraticLimits::of(robot);
  for (double& torque : tight.torque) torque *= 0.3;
  const auto make = [&](control::Fusion fusion) {
    return std::make_unique<control::TaskStack>(n, entries, fusion, control::Damping{}, tight);
  };

  robot::TaskCycleGains gains;
  gains.touch = skin_gains;
  gains.resolver.virtual_robot = {std::vector<double>(n, 0.2), std::vector<double>(n, 40)};
  gains.resolver.inner_loop.proportional.assign(n, 10);
  gains.resolver.inner_loop.integral.assign(n, 25);
  gains.resolver.inner_loop.derivative.assign(n, 0.1);
  robot::GuardLimits limits;
  limits.acceleration.assign(n, 100);
  limits.stop_deceleration.assign(n, 10);
  limits.torque_rate.assign(n, 1e4);
  robot::TaskCycle cycle(robot, model, gains, limits, make(control::Fusion::weighted_sum));

  JointState joints(n);
  for (std::size_t i = 0; i < n; ++i) joints.position[i] = std::clamp(0.1, robot.lower()[i], robot.upper()[i]);
  skin::SkinState skin;
  skin.resize(cells);
  std::ranges::fill(skin.health, skin::Health::alive);
  JointCommand command(CommandMode::position, n);
  std::uniform_real_distribution<float> force(0, 3);
  std::vector<double> goal(n);
  std::uint64_t visited = 0;
  long allocations = 0, switches = 0, running = 0;
  std::vector<CommandMode> mixed(n);
  for (std::size_t k = 0; k < n; ++k) mixed[k] = static_cast<CommandMode>(k % 3);
  for (int i = 0; i < cycles; ++i) {
    const std::int64_t now_ns = 1'000'000'000 + i * std::int64_t{1'000'000};
    joints.stamp_ns = skin.time_ns = now_ns;
    // Once in a while the joints, or the skin, are silent long enough to stop the robot, or part of the skin is.
    if (i % 2000 > 1850 && i % 2000 < 1900) joints.stamp_ns = now_ns - 1'000'000'000;
    if (i % 3000 > 2800) skin.time_ns = now_ns - 1'000'000'000;
    std::fill_n(skin.health.begin(), 60, i % 2500 > 2300 ? skin::Health::stale : skin::Health::alive);
    skin.normal_force[generator() % cells] = {force(generator), force(generator), force(generator)};
    if (i % 1000 == 500) {  // a person changes what the robot does; this is not the tick
      cycle.request_stack(make(static_cast<control::Fusion>(i / 1000 % 4)));
      for (std::size_t k = 0; k < n; ++k) goal[k] = std::clamp(0.3, robot.lower()[k], robot.upper()[k]);
      spline->request_reference(goal);
      ++switches;
    }
    if (i == 4777) joints.position[0] = std::numeric_limits<double>::quiet_NaN();
    allocations += allocations_of([&] {
      cycle.request_run(i % 1000 < 950);
      cycle.request_mode(static_cast<CommandMode>(i / 700 % 3));
      if (i % 700 > 500) (void)cycle.request_mode(mixed);
      cycle.request_skin(i % 900 < 600);
      (void)cycle.request_patch_mask(i % 3, i % 500 < 250);
      const robot::SafetyState state = cycle.step(joints, skin, now_ns, command).state;
      running += state == robot::SafetyState::running;
      visited |= std::uint64_t{1} << static_cast<int>(state);
    });
    if (i == 4777) joints.position[0] = 0;
    for (std::size_t k = 0; k < n; ++k)
      if (command.mode[k] == CommandMode::position) joints.position[k] = command.value[k];
    for (std::size_t k = 0; k < n; ++k)
      joints.position[k] = std::clamp(joints.position[k], robot.lower()[k], robot.upper()[k]);
  }
  const long counted = allocations_of([] { std::make_unique<std::vector<double>>(100); });
  std::printf("{\"allocations\": %ld, \"counted_of_two\": %ld, \"switches\": %ld, \"running\": %ld, ", allocations,
              counted, switches, running);
  std::printf("\"states_visited\": %d}\n", static_cast<int>(visited));
}
