// SPDX-License-Identifier: Apache-2.0
// A skin input written in Python.
#pragma once

#include "bindings/arrays.hpp"
#include "bindings/python_part.hpp"
#include "bindings/sensor_names.hpp"
#include "skin/skin_input.hpp"

namespace robotskin::bindings {

class PythonInput final : public skin::SkinInput, public PythonPart {
 public:
  NB_TRAMPOLINE(skin::SkinInput);

  PythonInput(std::size_t cell_count, double fresh_s, const std::vector<std::string>& sensors)
      : cell_count_(cell_count),
        fresh_ns_(static_cast<std::int64_t>(fresh_s * 1e9)),
        sensors_(sensors.empty() ? skin::all_sensors : sensor_set(sensors)) {
    if (fresh_ns_ <= 0) throw std::invalid_argument("fresh_s must be greater than 0");
  }

  std::size_t cell_count() const noexcept override { return cell_count_; }
  std::int64_t fresh_ns() const noexcept override { return fresh_ns_; }
  skin::SensorSet sensors() const noexcept override { return sensors_; }

  skin::InputStatus read(std::int64_t now_ns, skin::SkinState& state) noexcept override {
    return guarded(nb_trampoline, "read", skin::InputStatus::disconnected, [&] {
      const nanobind::detail::ticket ticket(nb_trampoline, "read", nanobind::detail::str_hash("read"), true);
      return status_of<skin::InputStatus>(
          nb_trampoline.base().attr(ticket.key)(now_ns, nanobind::cast(&state, nanobind::rv_policy::reference)),
          "InputStatus.ok, nothing_new or disconnected");
    });
  }
  void tell_joints(std::int64_t now_ns, std::span<const double> position) noexcept override {
    (void)guarded(nb_trampoline, "tell_joints", false, [&] {
      const nanobind::detail::ticket ticket(nb_trampoline, "tell_joints", nanobind::detail::str_hash("tell_joints"),
                                            false);
      if (ticket.key.is_valid()) nb_trampoline.base().attr(ticket.key)(now_ns, copy_of(position));
      return true;
    });
  }

 private:
  std::size_t cell_count_;
  std::int64_t fresh_ns_;
  skin::SensorSet sensors_;
};

}  // namespace robotskin::bindings
