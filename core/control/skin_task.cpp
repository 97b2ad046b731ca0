#include "control/skin_task.hpp"

#include <algorithm>
#include <array>

#include "control/control_error.hpp"

namespace robotskin::control {
namespace {

using Vector3 = std::array<double, 3>;

// The upper left of a row-major 4 x 4 transform.
Vector3 rotate(const double* transform, const Vector3& v) noexcept {
  Vector3 out;
  for (std::size_t row = 0; row < 3; ++row)
    out[row] = transform[4 * row] * v[0] + transform[4 * row + 1] * v[1] + transform[4 * row + 2] * v[2];
  return out;
}

Vector3 cross(const Vector3& a, const Vector3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

struct SkinTask::Column {
  std::size_t cell, joint;
  std::array<double, 6> wrench;  // of a unit touch
};

SkinTask::SkinTask(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains)
    : activation_(gains, skin.size()),
      magnitude_(skin.size() + WrenchBlock::columns),
      parent_(robot.joint_parents().begin(), robot.joint_parents().end()),
      joint_wrench_(6 * robot.joint_count()),
      base_wrench_(6 * robot.joint_count()) {
  std::vector<std::size_t> links;
  for (const std::string& name : skin.link_names) links.push_back(robot.link_index(name));

  std::vector<Column> columns;
  for (std::size_t cell = 0; cell < skin.size(); ++cell) {
    if (skin.link[cell] < 0 || static_cast<std::size_t>(skin.link[cell]) >= links.size())
      throw ControlError("cell " + std::to_string(cell) + " is on link " + std::to_string(skin.link[cell]) +
                         ": the skin has links 0 to " + std::to_string(links.size()) + " (exclusive)");
    const std::size_t link = links[skin.link[cell]];
    const int joint = robot.link_joints()[link];
    if (joint == RobotModel::base) continue;  // A cell on the base moves nothing.
    const double* joint_from_link = &robot.joint_from_link()[16 * link];
    const std::array<double, 9>& turn = skin.link_from_cell_rotation[cell];
    const Vector3 touch = rotate(joint_from_link, {-turn[2], -turn[5], -turn[8]});
    Vector3 point = rotate(joint_from_link, skin.link_from_cell_translation[cell]);
    for (std::size_t axis = 0; axis < 3; ++axis) point[axis] += joint_from_link[4 * axis + 3];
    const Vector3 moment = cross(point, touch);
    columns.push_back({cell, static_cast<std::size_t>(joint), {}});
    std::ranges::copy(touch, columns.back().wrench.begin());
    std::ranges::copy(moment, columns.back().wrench.begin() + 3);
  }
  std::ranges::stable_sort(columns, {}, &Column::joint);
  deal(columns);
}

// Into blocks and runs; columns are sorted by joint.
void SkinTask::deal(const std::vector<Column>& columns) {
  const auto same_body = [&](std::size_t i) { return i > 0 && columns[i].joint == columns[i - 1].joint; };
  bool together = true;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!same_body(i)) worn_.push_back(columns[i].joint);
    together = together && (!same_body(i) || columns[i].cell == columns[i - 1].cell + 1);
  }
  if (!together) {
    for (const Column& column : columns) sorted_cell_.push_back(static_cast<std::uint32_t>(column.cell));
    sorted_magnitude_.resize(columns.size() + WrenchBlock::columns);
  }
  std::size_t filled = 0;  // columns of the last block that stand for cells
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!same_body(i) || filled == WrenchBlock::columns) {
      if (!same_body(i) || runs_.back().block_count == WrenchRun::most_blocks)
        runs_.push_back({static_cast<std::uint32_t>(together ? columns[i].cell : i), 0,
                         static_cast<std::uint32_t>(columns[i].joint)});
      ++runs_.back().block_count;
      blocks_.emplace_back();
      filled = 0;
    }
    for (std::size_t row = 0; row < 6; ++row)
      blocks_.back().rows[row][filled] = static_cast<float>(columns[i].wrench[row]);
    ++filled;
  }
}

void SkinTask::aggregate() noexcept {
  for (std::size_t i = 0; i < sorted_cell_.size(); ++i) sorted_magnitude_[i] = magnitude_[sorted_cell_[i]];
  std::ranges::fill(joint_wrench_, 0.0);
  add_wrenches(runs_.data(), runs_.size(), blocks_.data(),
               sorted_cell_.empty() ? magnitude_.data() : sorted_magnitude_.data(), joint_wrench_.data());
}

std::span<const double> SkinTask::joint_wrenches() noexcept {
  aggregate();
  return joint_wrench_;
}

bool SkinTask::compute(const RobotDynamics& dynamics, const skin::SkinState& state, std::span<const float> share,
                       std::span<double> torque) noexcept {
  std::ranges::fill(torque, 0.0);
  const std::size_t joints = parent_.size();
  if (state.size() != cell_count() || share.size() != cell_count() || torque.size() != joints) return false;

  activation_.apply(state, share.data(), magnitude_.data());  // (14)
  aggregate();                                                // (22), (23)

  std::ranges::fill(base_wrench_, 0.0);
  const double *placements = dynamics.base_from_joint().data(), *motions = dynamics.joint_motions().data();
  for (const std::size_t joint : worn_) {  // (24) turned to the base, about its origin
    const double* base_from_joint = &placements[16 * joint];
    const double* wrench = &joint_wrench_[6 * joint];
    const Vector3 force = rotate(base_from_joint, {wrench[0], wrench[1], wrench[2]});
    const Vector3 moment = rotate(base_from_joint, {wrench[3], wrench[4], wrench[5]});
    const Vector3 arm = cross({base_from_joint[3], base_from_joint[7], base_from_joint[11]}, force);
    double* out = &base_wrench_[6 * joint];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out[axis] = force[axis];
      out[axis + 3] = moment[axis] + arm[axis];
    }
  }
  for (std::size_t joint = joints; joint-- > 0;) {  // (25) J^T W, where W is what acts on all that the joint carries
    const double* wrench = &base_wrench_[6 * joint];
    const double* motion = &motions[6 * joint];
    torque[joint] = (wrench[0] * motion[0] + wrench[1] * motion[1]) + (wrench[2] * motion[2] + wrench[3] * motion[3]) +
                    (wrench[4] * motion[4] + wrench[5] * motion[5]);
    if (parent_[joint] != RobotModel::base)
      for (std::size_t axis = 0; axis < 6; ++axis) base_wrench_[6 * parent_[joint] + axis] += wrench[axis];
  }
  return true;
}

}  // namespace robotskin::control
