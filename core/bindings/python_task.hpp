// SPDX-License-Identifier: Apache-2.0
// A task whose equation is a Python function.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <string>

#include "bindings/arrays.hpp"
#include "control/task.hpp"

namespace robotskin::bindings {

class PythonTask final : public control::Task {
 public:
  PythonTask(std::string name, std::size_t joint_count, std::size_t largest_rows, nanobind::callable compute)
      : Task(std::move(name), joint_count, largest_rows), compute_(std::move(compute)) {}
  ~PythonTask() override {
    const nanobind::gil_scoped_acquire lock;
    compute_.reset();
  }

  [[nodiscard]] bool update(const control::TaskInput& input) noexcept override {
    const nanobind::gil_scoped_acquire lock;
    try {
      take(compute_(nanobind::cast(&input.dynamics, nanobind::rv_policy::reference), copy_of(input.position),
                    copy_of(input.velocity), nanobind::cast(&input.skin, nanobind::rv_policy::reference)));
      error_.clear();
      return true;
    } catch (const std::exception& error) {
      error_ = error.what();
      return false;
    }
  }
  const std::string& error() const noexcept { return error_; }

 private:
  using Vector = nanobind::ndarray<const double, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;
  using Matrix = nanobind::ndarray<const double, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu>;

  void take(const nanobind::object& result) {
    const auto answer = nanobind::cast<nanobind::tuple>(result);
    if (answer.size() != 2) throw std::invalid_argument("compute must return (torque, rows)");
    const auto torque = nanobind::cast<Vector>(answer[0]);
    const auto rows = nanobind::cast<Matrix>(answer[1]);
    if (torque.shape(0) != joint_count() || rows.shape(1) != joint_count() || rows.shape(0) > largest_rows())
      throw std::invalid_argument("compute returned torque (" + std::to_string(torque.shape(0)) + ") and rows (" +
                                  std::to_string(rows.shape(0)) + ", " + std::to_string(rows.shape(1)) +
                                  "): the robot has " + std::to_string(joint_count()) +
                                  " joints, and rows are at most " + std::to_string(largest_rows()));
    std::copy_n(torque.data(), torque.size(), torque_.begin());
    std::copy_n(rows.data(), rows.size(), rows_.begin());
    row_count_ = rows.shape(0);
  }

  nanobind::callable compute_;
  std::string error_;
};

}  // namespace robotskin::bindings
