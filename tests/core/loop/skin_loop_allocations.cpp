// SPDX-License-Identifier: Apache-2.0
// Runs the loop between a port and an input that fail in turns; prints its allocations as JSON. Arguments: URDF, seed.
#include <cstdio>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <vector>

#include "../count_allocations.hpp"
#include "../robot/random_skin.hpp"
#include "control/gravity_task.hpp"
#include "control/joint_task.hpp"
#include "control/skin_reaction_task.hpp"
#include "loop/paced_loop.hpp"
#include "loop/skin_loop.hpp"
#include "skin/foreign_input.hpp"

using namespace robotskin;

namespace {

constexpr int ticks = 6000, runs = 100;

// Follows its position commands; answers amiss when it is told to.
class Arm final : public RobotPort {
 public:
  explicit Arm(std::size_t n) : position_(n) {}
  std::size_t joint_count() const noexcept override { return position_.size(); }
  bool offers(CommandMode mode) const noexcept override { return mode == CommandMode::position; }
  PortSensors sensors() const override { return {.imus = {{.name = "imu", .link = "base"}}, .forces = {}}; }
  double period_s() const noexcept override { return 0.0005; }
  void await_state(std::int64_t until_ns) noexcept override {
    RobotPort::await_state(until_ns);
    unread += awaited;
    awaited = true;
  }
  PortStatus read(JointState& state) noexcept override {
    awaited = false;
    if (fails) return PortStatus::disconnected;
    std::copy(position_.begin(), position_.end(), state.position.begin());
    state.stamp_ns = now_ns;
    return PortStatus::ok;
  }
  PortStatus read_sensors(SensorReadings& readings) noexcept override {
    readings.imus[0].acceleration = {0, 0, 9.81};
    readings.imus[0].stamp_ns = now_ns;
    return PortStatus::ok;
  }
  PortStatus write(const JointCommand& command) noexcept override {
    if (refuses) return PortStatus::refused;
    std::copy(command.value.begin(), command.value.end(), position_.begin());
    return PortStatus::ok;
  }
  void stop() noexcept override { ++stops; }

  std::int64_t now_ns = 0;
  bool fails = false, refuses = false;
  bool awaited = false;
  long stops = 0, unread = 0;

 private:
  std::vector<double> position_;
};

class Palm final : public skin::SkinInput {
 public:
  std::size_t cell_count() const noexcept override { return cells; }
  skin::InputStatus read(std::int64_t now_ns, skin::SkinState& state) noexcept override {
    if (fails) return skin::InputStatus::disconnected;
    for (std::size_t cell = 0; cell < cells; ++cell) {
      state.health[cell] = skin::Health::alive;
      state.stamp_ns[cell] = now_ns;
    }
    state.normal_force[0] = {force, force, force};
    state.time_ns = now_ns;
    return skin::InputStatus::ok;
  }

  bool fails = false;
  float force = 0;
};

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
  const auto felt = std::make_shared<control::TouchWrench>(robot, model, skin_gains);
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
  const control::JointGains joint_gains{std::vector<double>(n, 100), std::vector<double>(n, 5)};
  const std::vector<control::StackEntry> entries = {{std::make_shared<control::JointTask>(robot, joint_gains), 0},
                                                    {std::make_shared<control::SkinReactionTask>(felt, 80), 0},
                                                    {std::make_shared<control::GravityTask>(n), -1}};
  robot::TaskCycle cycle(robot, model, gains, limits,
                         std::make_unique<control::TaskStack>(n, entries, control::Fusion::weighted_sum));
  Arm arm(n);
  Palm palm;
  loop::SkinLoop loop(arm, palm, cycle);

  std::uniform_real_distribution<float> force(0, 3);
  long allocations = 0, running = 0, latched = 0;
  for (int i = 0; i < ticks; ++i) {
    arm.now_ns = 1'000'000'000 + i * std::int64_t{1'000'000};
    arm.fails = i % 2000 > 1210 && i % 2000 < 1290;
    arm.refuses = i % 3000 > 2710 && i % 3000 < 2760;
    palm.fails = i % 1700 > 1500;
    palm.force = force(generator);
    allocations += allocations_of([&] {
      if (i % 100 == 0) loop.request_run(i % 500 < 400);
      latched += loop.step(arm.now_ns).latched;
      running += loop.guard().state == robot::SafetyState::running;
    });
  }
  // The same over another maker's skin, fed as by its thread.
  skin::ForeignInput foreign(cells, {});
  loop::SkinLoop foreign_loop(arm, foreign, cycle);
  arm.fails = arm.refuses = false;
  long felt_ticks = 0;
  for (int i = 0; i < ticks; ++i) {
    arm.now_ns = 20'000'000'000 + i * std::int64_t{1'000'000};
    if (i == 50) foreign.tare(100'000'000);
    allocations += allocations_of([&] {
      if (i % 10 == 0) {
        for (std::size_t cell = 0; cell < cells; ++cell) {
          skin::ForeignSample& sample = foreign.change(cell);
          sample.stamp_ns = arm.now_ns;
          ++sample.samples;
          sample.normal_force = {0.1F, 0.1F, 0.1F};
        }
        foreign.publish(arm.now_ns);
      }
      if (i % 100 == 0) foreign_loop.request_run(i % 500 < 400);
      foreign_loop.step(arm.now_ns);
      felt_ticks += foreign_loop.guard().state == robot::SafetyState::running;
    });
  }
  // Run after run, a state that was waited for is read before another is waited for.
  loop::PacedLoop paced(loop, arm.period_s());
  for (int run = 0; run < runs; ++run) paced.run(2.6 * arm.period_s());
  const long counted = allocations_of([] { std::make_unique<std::vector<double>>(100); });
  std::printf(
      "{\"allocations\": %ld, \"counted_of_two\": %ld, \"running\": %ld, \"latched\": %ld, \"stops\": %ld, "
      "\"felt_ticks\": %ld, \"paced_ticks\": %ld, \"unread\": %ld}\n",
      allocations, counted, running, latched, arm.stops, felt_ticks, static_cast<long>(paced.ticks()), arm.unread);
}
