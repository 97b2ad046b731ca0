// SPDX-License-Identifier: Apache-2.0
#include "control/touch_matrix.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "control/control_error.hpp"
#include "model/spatial.hpp"

namespace robotskin::control {

struct TouchMatrix::Column {
  std::size_t cell, joint;
  std::array<double, 6> wrench;  // of a unit touch
};

TouchMatrix::TouchMatrix(const RobotModel& robot, const skin::SkinModel& skin)
    : cell_count_(skin.size()), parent_(robot.joint_parents().begin(), robot.joint_parents().end()) {
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
    const Matrix3& turn = skin.link_from_cell_rotation[cell];
    const Vector3 touch = rotate(joint_from_link, {-turn[2], -turn[5], -turn[8]});
    const Vector3 moment =  // [Cheng19 eq. 22], of 1 N
        cross(place(joint_from_link, skin.link_from_cell_translation[cell]), touch);
    columns.push_back({cell, static_cast<std::size_t>(joint), {}});
    std::ranges::copy(touch, columns.back().wrench.begin());
    std::ranges::copy(moment, columns.back().wrench.begin() + 3);
  }
  std::ranges::stable_sort(columns, {}, &Column::joint);
  pack(columns);

  carried_.assign(body_count() * joint_count(), 0);
  for (std::size_t body = 0; body < body_count(); ++body)
    for (int i = static_cast<int>(body_joint_[body]); i != RobotModel::base; i = parent_[static_cast<std::size_t>(i)])
      carried_[body * joint_count() + static_cast<std::size_t>(i)] = 1;
}

// Into blocks and runs; columns are sorted by joint.
void TouchMatrix::pack(const std::vector<Column>& columns) {
  const auto same_body = [&](std::size_t i) { return i > 0 && columns[i].joint == columns[i - 1].joint; };
  bool together = true;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!same_body(i)) body_joint_.push_back(columns[i].joint);
    together = together && (!same_body(i) || columns[i].cell == columns[i - 1].cell + 1);
  }
  if (!together)
    for (const Column& column : columns) sorted_cell_.push_back(static_cast<std::uint32_t>(column.cell));
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

void TouchMatrix::multiply(const float* magnitude, float* sorted, std::span<double> wrenches) const noexcept {
  for (std::size_t i = 0; i < sorted_cell_.size(); ++i) sorted[i] = magnitude[sorted_cell_[i]];
  std::ranges::fill(wrenches, 0.0);
  add_wrenches(runs_.data(), runs_.size(), blocks_.data(), sorted_cell_.empty() ? magnitude : sorted, wrenches.data());
}

}  // namespace robotskin::control
