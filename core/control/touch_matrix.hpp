// SPDX-License-Identifier: Apache-2.0
// What is constant about the wrenches of touch: on which body each cell is, and what a unit touch of it does there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/wrench_product.hpp"
#include "model/robot_model.hpp"
#include "skin/cell_array.hpp"
#include "skin/skin_model.hpp"

namespace robotskin::control {

// A cell's force acts along its constant normal, so the wrench of all cells of a moving body is a constant 6 x n matrix
// times their magnitudes [Cheng19 eq. 22, 23]. The touch on the robot is -z: a hand pushes the arm away from itself.
// A body is a joint whose links have cells. Immutable, so that tasks and threads may share it.
class TouchMatrix {
 public:
  // Throws ModelError for a link the robot does not have, ControlError for a cell on a link the skin does not have.
  TouchMatrix(const RobotModel& robot, const skin::SkinModel& skin);

  std::size_t cell_count() const noexcept { return cell_count_; }
  std::size_t joint_count() const noexcept { return parent_.size(); }
  std::span<const int> joint_parents() const noexcept { return parent_; }

  std::size_t body_count() const noexcept { return body_joint_.size(); }
  std::size_t body_joint(std::size_t body) const noexcept { return body_joint_[body]; }
  // True if the body is carried by the joint or is the joint's own.
  bool carried_by(std::size_t body, std::size_t joint) const noexcept {
    return carried_[body * joint_count() + joint] != 0;
  }

  // Entries a magnitude array must have: the cells, and some zeros that the last block of columns may reach.
  std::size_t padded_count() const noexcept { return cell_count_ + WrenchBlock::columns; }
  std::size_t sorted_count() const noexcept {
    return sorted_cell_.empty() ? 0 : sorted_cell_.size() + WrenchBlock::columns;
  }

  // wrenches (n, 6) = force and moment about each joint's origin, in the joint's frame, of magnitude (padded_count)
  // newton. `sorted` (sorted_count) is room that the product needs.
  void multiply(const float* magnitude, float* sorted, std::span<double> wrenches) const noexcept;

 private:
  struct Column;
  void pack(const std::vector<Column>& columns);

  std::size_t cell_count_;
  std::vector<WrenchRun> runs_;
  std::vector<WrenchBlock> blocks_;  // the touch -z in the joint frame and p x -z of each cell
  // Where the cells of a body do not follow each other, the forces are sorted by body first.
  std::vector<std::uint32_t> sorted_cell_;  // (columns) cell of each column, nothing where they do follow
  std::vector<int> parent_;                 // (n)
  std::vector<std::size_t> body_joint_;     // (bodies), ascending
  std::vector<unsigned char> carried_;      // (bodies, n)
};

}  // namespace robotskin::control
