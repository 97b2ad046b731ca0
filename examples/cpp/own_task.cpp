// SPDX-License-Identifier: Apache-2.0
// A task of one's own in C++: whatever else moves the robot, its hand stays under a ceiling. Argument: a URDF's path.
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <fstream>
#include <memory>
#include <robotskin/control/gravity_task.hpp>
#include <robotskin/control/joint_task.hpp>
#include <robotskin/robot/task_cycle.hpp>
#include <sstream>
#include <string>
#include <vector>

using namespace robotskin;

// A spring from 10 mm below the ceiling on: torque = -k z_too_high J_z^T; claims the hand's motion along z of the base.
class CeilingTask final : public control::Task {
 public:
  CeilingTask(const RobotModel& robot, const std::string& hand, double ceiling_m)
      : Task("ceiling", robot.joint_count(), 1),
        hand_(robot.link_index(hand)),
        ceiling_m_(ceiling_m),
        jacobian_(6 * robot.joint_count()) {}

  [[nodiscard]] bool update(const control::TaskInput& input) noexcept override {
    std::array<double, 16> base_from_hand{};
    if (!input.dynamics.base_from_link(hand_, base_from_hand) || !input.dynamics.link_jacobian(hand_, jacobian_))
      return false;
    const double too_high_m = std::max(0.0, base_from_hand[11] - (ceiling_m_ - 0.01));
    const double* up = &jacobian_[2 * joint_count()];  // (n) velocity along z by joint velocity
    for (std::size_t joint = 0; joint < joint_count(); ++joint) {
      torque_[joint] = -20000 * too_high_m * up[joint];
      rows_[joint] = std::min(1.0, too_high_m / 0.005) * up[joint];
    }
    row_count_ = 1;
    return true;
  }

 private:
  std::size_t hand_;
  double ceiling_m_;
  std::vector<double> jacobian_;  // (6, n)
};

double height_m(RobotDynamics& dynamics, const JointState& joints, std::size_t hand) {
  std::array<double, 16> base_from_hand{};
  if (!dynamics.update(joints.position, joints.velocity) || !dynamics.base_from_link(hand, base_from_hand)) return 0;
  return base_from_hand[11];
}

int run(const char* path) {
  std::ostringstream urdf;
  urdf << std::ifstream(path).rdbuf();
  const RobotModel robot(urdf.str());
  const std::size_t n = robot.joint_count(), hand = robot.link_index("ee_link");
  skin::SkinModel one_cell;  // untouched; without fresh skin the guard lets no robot run
  one_cell.key = {1};
  one_cell.link_names = {"ee_link"};
  one_cell.link = {0};
  one_cell.link_from_cell_rotation = {{1, 0, 0, 0, 1, 0, 0, 0, 1}};
  one_cell.link_from_cell_translation = {{0, 0, 0}};
  one_cell.neighbours.resize(1);
  one_cell.patch = {0};
  RobotDynamics dynamics(robot);

  JointState joints(n);
  joints.position = {0, -1.4, 1.5, -1.67, -1.5708, 0};
  const double ceiling_m = height_m(dynamics, joints, hand) + 0.02;
  const auto posture = std::make_shared<control::JointTask>(
      robot, control::JointGains{std::vector<double>(n, 1000), std::vector<double>(n)});
  std::vector<double> higher = joints.position;
  higher[2] -= 0.5;  // this elbow would lift the hand by 0.2 m
  auto stack = std::make_unique<control::TaskStack>(
      n,
      std::vector<control::StackEntry>{{std::make_shared<CeilingTask>(robot, "ee_link", ceiling_m), 0},
                                       {posture, 1},
                                       {std::make_shared<control::GravityTask>(n), control::StackEntry::feedforward}},
      control::Fusion::null_space);

  robot::TaskCycleGains gains;
  gains.touch = control::SkinGains::uniform(one_cell.size(), 1, 0, 0.35F, 0.9F, 0.02F, 0.05F);
  gains.resolver.virtual_robot = {std::vector<double>(n, 0.2), std::vector<double>(n, 450)};
  gains.resolver.inner_loop = {std::vector<double>(n, 10), std::vector<double>(n, 25), std::vector<double>(n)};
  robot::GuardLimits limits;
  limits.acceleration.assign(n, 100);
  limits.stop_deceleration.assign(n, 10);
  limits.torque_rate.assign(n, 1e4);
  robot::TaskCycle cycle(robot, one_cell, gains, limits, std::move(stack));

  skin::SkinState skin;
  skin.resize(one_cell.size());
  skin.health = {skin::Health::alive};
  JointCommand command(CommandMode::position, n);
  cycle.request_run(true);
  double highest_m = 0;
  for (int tick = 1; tick <= 5000; ++tick) {  // 5 s of a robot that is where it was told to be
    if (tick == 100) posture->request_reference(higher);
    joints.stamp_ns = skin.time_ns = tick * std::int64_t{1'000'000};
    if (cycle.step(joints, skin, skin.time_ns, command).send) joints.position = command.value;
    highest_m = std::max(highest_m, height_m(dynamics, joints, hand));
  }
  std::printf("%s: the hand rose to %.1f mm under the ceiling\n",
              cycle.report().state == robot::SafetyState::running ? "running" : "stopped",
              1e3 * (ceiling_m - highest_m));
  return highest_m < ceiling_m && highest_m > ceiling_m - 0.015 ? 0 : 1;
}

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::fprintf(stderr, "usage: own_task URDF; of a UR5, whose last link is ee_link\n");
    return 2;
  }
  try {
    return run(arguments[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "own_task: %s: %s\n", arguments[1], error.what());
    return 2;
  }
}
