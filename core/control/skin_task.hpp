// Skin task: the joint torques that a touch asks for (eq. 14 to 17), at the cost of one small product a link
// (eq. 22 to 25).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/skin_activation.hpp"
#include "control/wrench_product.hpp"
#include "model/robot_dynamics.hpp"
#include "model/robot_model.hpp"
#include "skin/skin_model.hpp"
#include "skin/skin_state.hpp"

namespace robotskin::control {

// A cell's force acts along its constant normal, so the wrench of all cells of a moving body is a constant 6 x n
// matrix times their magnitudes. The touch on the robot is -z: a hand pushes the arm away from itself.
class SkinTask {
 public:
  // Throws ModelError for a link the robot does not have, ControlError for gains that do not fit the skin.
  SkinTask(const RobotModel& robot, const skin::SkinModel& skin, const SkinGains& gains);

  std::size_t cell_count() const noexcept { return activation_.cell_count(); }

  // torque (n) Nm at the posture of the last update of dynamics. `share` (N) 0 to 1: 0 masks a cell. False, with zero
  // torque, if the state or the share does not have N cells or the torque n joints.
  [[nodiscard]] bool compute(const RobotDynamics& dynamics, const skin::SkinState& state, std::span<const float> share,
                             std::span<double> torque) noexcept;

  // (N) newton, what each cell asked for in the last compute, in the order of the skin model.
  std::span<const float> magnitudes() const noexcept { return std::span(magnitude_).first(cell_count()); }

  // (n, 6) force and moment about the joint's origin, in the joint's frame, that the cells of each joint's body asked
  // for in the last compute (23).
  std::span<const double> body_wrenches() const noexcept { return joint_wrench_; }

  // The bare product, without activation and torques: (n, 6) force, moment about the joint's origin, joint frame.
  std::span<const double> joint_wrenches() noexcept;

 private:
  void aggregate() noexcept;

  struct Column;
  void deal(const std::vector<Column>& columns);

  SkinActivation activation_;
  skin::CellArray<float> magnitude_;  // (N, and some zeros that the last block of columns may reach)
  std::vector<WrenchRun> runs_;
  std::vector<WrenchBlock> blocks_;  // the touch -z in the joint frame and p x -z of each cell
  // Where the cells of a body do not follow each other, the forces are sorted by body first.
  std::vector<std::uint32_t> sorted_cell_;  // (columns) cell of each column, nothing where they do follow
  skin::CellArray<float> sorted_magnitude_;
  std::vector<std::size_t> worn_;  // joints whose bodies have cells
  std::vector<int> parent_;
  std::vector<double> joint_wrench_;  // (n, 6)
  std::vector<double> base_wrench_;   // (n, 6) about the base's origin, in the base frame; of the subtree
};

}  // namespace robotskin::control
