// SPDX-License-Identifier: Apache-2.0
#include "campaign/touch_checker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "campaign/datagram_frames.hpp"
#include "campaign/epoch_times.hpp"
#include "world/random.hpp"

namespace robotskin::campaign {
namespace {

constexpr std::uint64_t purpose_touch = 43;
constexpr std::int64_t agreed_ns = 150 * ms;
constexpr double force_error = 2e-3, least_force_n = 1e-3;
constexpr std::int64_t broadcast_epochs = 8;  // a posture is on its way, and stands for its epoch and the next
constexpr unsigned root_port_bits = 4;        // of a root's number; the section unit's are above

// Between the times of section units. They take half the round trip for the way, so that ways of different lengths
// keep them apart for good, but by no more than lets them leap.
std::int64_t apart_ms(const world::Network& network) {
  std::int64_t first_ms = std::numeric_limits<std::int64_t>::max(), last_ms = 0;
  for (std::size_t u = 0; u < network.unit_count(); ++u) {
    if (!network.unit_runs(u)) continue;
    const auto time_ms = static_cast<std::int64_t>(network.unit(u).tick_time);
    first_ms = std::min(first_ms, time_ms);
    last_ms = std::max(last_ms, time_ms);
  }
  return std::clamp(last_ms - first_ms, std::int64_t{0}, std::int64_t{RS_PEER_TOGETHER_US * us / ms});
}

}  // namespace

std::array<std::int16_t, RS_JOINTS_PER_PART> posture_at(std::uint64_t seed, std::int64_t time_ms) {
  std::array<std::int16_t, RS_JOINTS_PER_PART> posture{static_cast<std::int16_t>(time_ms)};
  for (std::size_t i = 1; i < posture.size(); ++i)
    posture[i] = static_cast<std::int16_t>(world::scramble(seed ^ static_cast<std::uint16_t>(time_ms) << 3 ^ i));
  return posture;
}

TouchChecker::TouchChecker(const FaultCase& drawn, BreakLog& breaks) : breaks_(breaks), seed_(drawn.seed) {
  if (!drawn.workload.touch) return;
  world::RandomStream draw(world::stream_key(drawn.seed, purpose_touch, 0));
  const int step_bits = 8 + static_cast<int>(draw.below(3));
  for (std::size_t cell = 0; cell < drawn.wiring.cell_count(); ++cell)
    cells_.push_back({.model = TouchModel(draw, step_bits)});
}

void TouchChecker::prepare(world::Network& network) const {
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) network.set_torque_image(cell, cells_[cell].model.image());
}

TouchChecker::Epoch& TouchChecker::epoch_of(std::uint32_t number, std::int64_t now_ns) {
  Epoch& epoch = epochs_[number & RS_EPOCH_MASK];
  if (epoch.first_ns < 0 || now_ns - epoch.first_ns > forgotten_ns) epoch = {.first_ns = now_ns};
  return epoch;
}

void TouchChecker::cell_stepped(const world::Network& network, const GroundTruth& ground, std::size_t index,
                                const rs_input& input) {
  if (!in_use()) return;
  Cell& cell = cells_[index];
  const rs_cell& state = network.cell(index);
  const std::int64_t now_ns = network.time_ns();
  const bool begun = state.torque.epoch != cell.epoch;
  cell.epoch = state.torque.epoch;
  const auto unit = static_cast<std::uint8_t>(state.route.wave.root >> root_port_bits);
  if (unit != cell.unit) cell.came_ns = now_ns;
  cell.unit = unit;
  // A cell whose parameters were damaged gives up its torques, which the host would have to send it again.
  if (ground.lawless(now_ns, index)) {
    cell.corrupted = true;
    if (begun) epoch_of(cell.epoch, now_ns).excused = true;
    return;
  }
  if (input.kind == RS_INPUT_BOOT || state.cell_torque.known) cell.corrupted = false;
  if (cell.corrupted && state.torque.own.parts == 0) return;
  if (!state.cell_torque.known || state.cell_torque.parameters.chain.joints != cell.model.joints()) {
    breaks_.add(Invariant::torque_true, now_ns, {index}, {{"knows its parameters", state.cell_torque.known}});
    return;
  }
  if (input.kind == RS_INPUT_SAMPLE && state.cell_torque.felt) judge_force(network, index, *input.sample);
  if (!begun || state.route.wave.forming != 0 || state.torque.own.parts == 0) return;
  Epoch& epoch = epoch_of(cell.epoch, now_ns);
  ++epoch.given.cells;
  epoch.given.active += state.torque.own.active ? 1 : 0;
  for (std::size_t i = 0; i < RS_JOINTS_PER_PART; ++i) epoch.given.joint[i] += state.torque.own.joint[i];
  // Of another sample or posture than the torques are, if that came in this step.
  if (input.kind == RS_INPUT_SAMPLE) return;
  if (input.kind == RS_INPUT_FRAME && rs_frame_type_of(input.frame) == RS_TYPE_joints) return;
  judge_torques(network, ground, index);
}

void TouchChecker::judge_force(const world::Network& network, std::size_t index, const rs_sample& sample) {
  const double must_be = cells_[index].model.force(sample);
  const double is = std::ldexp(network.cell(index).cell_torque.force, -RS_FORCE_BITS);
  if (std::abs(is - must_be) > force_error * must_be + least_force_n)
    breaks_.add(Invariant::torque_true, network.time_ns(), {index},
                {{"force of touch, mN", std::lround(1e3 * is)}, {"must be", std::lround(1e3 * must_be)}});
}

void TouchChecker::judge_torques(const world::Network& network, const GroundTruth& ground, std::size_t index) {
  const rs_cell& state = network.cell(index);
  const TouchModel& model = cells_[index].model;
  const rs_contribution& own = state.torque.own;
  const std::int64_t now_ns = network.time_ns();
  ++judged_;
  const std::span<const std::int16_t> position(state.joints.position, RS_JOINTS_PER_PART);
  const auto posture = posture_at(seed_, position[0]);
  const auto age_ms = static_cast<std::int16_t>(now_ns / ms - position[0]);
  // While section units agree on a time, epochs leap.
  const bool timed = now_ns > agreed_ns && ground.calm(now_ns) && ground.repaired_ns() < now_ns - agreed_ns;
  // A posture of before the cell came over was numbered by the time of another unit.
  const std::int64_t off_ms = now_ns - age_ms * ms <= cells_[index].came_ns ? apart_ms(network) : 0;
  const bool true_age = age_ms + off_ms >= (own.age - 2) * RS_EPOCH_TICKS &&
                        age_ms - off_ms <= (own.age + broadcast_epochs) * RS_EPOCH_TICKS;
  if (!std::ranges::equal(position, posture) || (timed && !true_age))
    breaks_.add(Invariant::torque_true, now_ns, {index},
                {{"posture, ms old", age_ms}, {"age told, epochs", own.age}, {"second joint", position[1]}});
  const double force = std::ldexp(state.cell_torque.force, -RS_FORCE_BITS);
  if (own.active != (state.cell_torque.force > 0))
    breaks_.add(Invariant::torque_true, now_ns, {index}, {{"touched", own.active}});
  const TouchModel::Torques must_be = model.torques(force, position);
  for (std::size_t l = 0; l < TouchModel::joints_max; ++l)
    if (std::abs(own.joint[l] - must_be[l]) > (l < model.joints() ? model.tolerance(force) : 0))
      breaks_.add(
          Invariant::torque_true, now_ns, {index},
          {{"joint", static_cast<std::int64_t>(l)}, {"steps", own.joint[l]}, {"must be", std::lround(must_be[l])}});
}

void TouchChecker::datagram(const world::Network& network, std::span<const std::uint8_t> datagram) {
  if (!in_use()) return;
  for_each_frame(datagram, [&](const std::uint8_t* frame_at) {
    if (rs_frame_type_of(frame_at) != RS_TYPE_torque) return;
    rs_torque torque;
    rs_torque_unpack(&torque, frame_at);
    if (torque.cells == 0) return;
    Epoch& epoch = epoch_of(torque.epoch, network.time_ns());
    epoch.excused = epoch.excused || torque.saturated != 0;
    epoch.told.cells += torque.cells;
    epoch.told.active += torque.active;
    const std::array<std::int32_t, RS_JOINTS_PER_PART> joints{torque.joint_1, torque.joint_2, torque.joint_3,
                                                              torque.joint_4, torque.joint_5, torque.joint_6};
    for (std::size_t i = 0; i < joints.size(); ++i) epoch.told.joint[i] += joints[i];
  });
}

// Sums may miss cells (torque_complete); one that misses none is right.
void TouchChecker::poll(const world::Network& network, const GroundTruth& ground) {
  if (!in_use()) return;
  const std::int64_t now_ns = network.time_ns();
  for (Epoch& epoch : epochs_) {
    if (epoch.judged || epoch.first_ns < 0 || now_ns - epoch.first_ns < complete_ns) continue;
    epoch.judged = true;
    const bool quiet = ground.calm_elsewhere(now_ns) && ground.repaired_elsewhere_ns() < epoch.first_ns - at_rest_ns;
    if (epoch.excused || !quiet || epoch.told.cells != epoch.given.cells) continue;
    ++sums_judged_;
    if (epoch.told == epoch.given) continue;
    breaks_.add(Invariant::torque_true, now_ns, {},
                {{"cells", epoch.given.cells},
                 {"touched", epoch.given.active},
                 {"told", epoch.told.active},
                 {"first joint, steps", epoch.given.joint[0]},
                 {"told", epoch.told.joint[0]}});
  }
}

}  // namespace robotskin::campaign
