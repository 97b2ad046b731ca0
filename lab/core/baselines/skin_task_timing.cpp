// SPDX-License-Identifier: Apache-2.0
#include "baselines/skin_task_timing.hpp"

#include <algorithm>
#include <chrono>

#include "baselines/plain_product.hpp"
#include "control/wrench_product.hpp"

namespace robotskin::lab {
namespace {

using control::add_wrenches;
using control::TouchWrench;
using control::WrenchBlock;
using control::WrenchRun;

template <typename Work>
void measure(std::vector<std::int64_t>& times, Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  times.push_back(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start).count());
}

// The bare product of all cells as if they were on one body, its rows where they are fastest.
class PlainProduct {
 public:
  explicit PlainProduct(std::size_t cells) : matrix_(6 * stride(cells), 0.5), magnitude_(cells, 1.0) {}
  void operator()() noexcept {
    plain_product(matrix_.data(), stride(magnitude_.size()), magnitude_.data(), magnitude_.size(), wrench_);
  }

 private:
  static std::size_t stride(std::size_t cells) { return (cells + 7) / 8 * 8; }  // whole cache lines

  skin::CellArray<double> matrix_, magnitude_;
  double wrench_[6];
};

class SingleProduct {
 public:
  explicit SingleProduct(std::size_t cells)
      : blocks_((cells + WrenchBlock::columns - 1) / WrenchBlock::columns), force_(cells + WrenchBlock::columns, 1.0F) {
    for (WrenchBlock& block : blocks_)
      for (auto& row : block.rows) std::ranges::fill(row, 0.5F);
    for (std::size_t block = 0; block < blocks_.size(); block += WrenchRun::most_blocks)
      runs_.push_back({static_cast<std::uint32_t>(block * WrenchBlock::columns),
                       static_cast<std::uint32_t>(std::min(blocks_.size() - block, WrenchRun::most_blocks)), 0});
  }
  void operator()() noexcept { add_wrenches(runs_.data(), runs_.size(), blocks_.data(), force_.data(), wrench_); }

 private:
  std::vector<WrenchRun> runs_;
  std::vector<WrenchBlock> blocks_;
  skin::CellArray<float> force_;
  double wrench_[6]{};
};

}  // namespace

SkinTaskTimes time_skin_task(const RobotModel& robot, const skin::SkinModel& skin, const control::SkinGains& gains,
                             const skin::SkinState& state, const skin::SkinState& other,
                             std::span<const double> position, std::size_t rounds) {
  TouchWrench task(robot, skin, gains);
  NaiveSkinTask naive(robot, skin);
  RobotDynamics dynamics(robot);
  const std::vector<double> at_rest(robot.joint_count());
  const skin::CellArray<float> share(skin.size(), 1.0F);
  std::vector<double> torque(robot.joint_count());
  PlainProduct product(skin.size());
  SingleProduct single(skin.size());

  SkinTaskTimes times;
  for (auto* values : {&times.product, &times.single, &times.task, &times.kinematics, &times.naive})
    values->reserve(rounds);
  bool computed = true;
  for (std::size_t round = 0; round < rounds; ++round) {
    const skin::SkinState& current = round % 2 == 0 ? state : other;
    measure(times.kinematics, [&] { computed = dynamics.update(position, at_rest) && computed; });
    measure(times.task, [&] { computed = task.compute(dynamics, current, share) && computed; });
    computed = dynamics.update(position, at_rest) && computed;  // so that the product finds the caches as the task did
    measure(times.product, product);
    computed = dynamics.update(position, at_rest) && computed;
    measure(times.single, single);
    if (round % 10 == 0) measure(times.naive, [&] { naive.compute(dynamics, task.magnitudes(), torque); });
  }
  return computed ? times : SkinTaskTimes{};
}

std::vector<std::int64_t> time_dynamics_update(const RobotModel& robot, std::span<const double> position,
                                               std::size_t rounds) {
  RobotDynamics dynamics(robot);
  const std::vector<double> at_rest(robot.joint_count());
  std::vector<std::int64_t> times;
  bool computed = true;
  for (std::size_t round = 0; round < rounds; ++round)
    measure(times, [&] { computed = dynamics.update(position, at_rest) && computed; });
  return computed ? times : std::vector<std::int64_t>{};
}

}  // namespace robotskin::lab
