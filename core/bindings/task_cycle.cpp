// SPDX-License-Identifier: Apache-2.0
// Binds the task cycle.
#include "robot/task_cycle.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>
#include <time.h>

#include <chrono>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "bindings/guard_counts.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using control::Damping;
using control::Fusion;
using control::QuadraticLimits;
using control::StackEntry;
using control::TaskStack;
using robot::GuardReport;
using robot::StateLog;
using robot::TaskCycle;
using robot::TaskCycleGains;

void require_joints(std::size_t joints, const JointState& state, const JointCommand& command) {
  if (state.position.size() != joints || state.velocity.size() != joints || command.value.size() != joints ||
      command.mode.size() != joints)
    throw std::invalid_argument("joint state and command must have one entry a joint");
}

nb::dict log_of(const TaskCycle& self) {
  const StateLog& log = self.log();
  const std::size_t ticks = log.count(), joints = log.joint_count();
  std::vector<double> values(ticks * StateLog::width * joints);
  std::vector<std::int64_t> times(ticks);
  std::vector<std::uint8_t> states(ticks), modes(ticks * joints);
  for (std::size_t i = 0; i < ticks; ++i) {
    times[i] = log.tick(i).time_ns;
    states[i] = static_cast<std::uint8_t>(log.tick(i).state);
    std::ranges::transform(log.modes(i), modes.begin() + static_cast<std::ptrdiff_t>(i * joints),
                           [](CommandMode mode) { return static_cast<std::uint8_t>(mode); });
    std::ranges::copy(log.values(i), values.begin() + static_cast<std::ptrdiff_t>(i * StateLog::width * joints));
  }
  nb::dict result;
  result["time_ns"] = copy_of(std::span<const std::int64_t>(times));
  result["state"] = copy_of(std::span<const std::uint8_t>(states));
  result["mode"] = copy_of(std::span<const std::uint8_t>(modes), {ticks, joints});
  result["values"] = copy_of(std::span<const double>(values), {ticks, StateLog::width, joints});
  return result;
}

}  // namespace

void bind_task_cycle(nb::module_& module) {
  nb::enum_<control::SkinSource>(module, "SkinSource", "Which side sums the torque of touch.")
      .value("host", control::SkinSource::host)
      .value("skin", control::SkinSource::skin);
  nb::class_<TaskCycleGains>(module, "TaskCycleGains", "Gains of the task cycle beside those of its tasks.")
      .def(
          "__init__",
          [](TaskCycleGains* self, control::SkinGains touch, control::ResolverGains resolver) {
            new (self) TaskCycleGains{std::move(touch), std::move(resolver)};
          },
          "touch"_a, "resolver"_a)
      .def_rw("touch", &TaskCycleGains::touch, "SkinGains: which forces count as a touch; the weights are not read")
      .def_rw("resolver", &TaskCycleGains::resolver, "ResolverGains; their period is the cycle's")
      .def_rw("touch_bandwidth_hz", &TaskCycleGains::touch_bandwidth_hz, "Hz, low-pass of the measured touch; 0: none")
      .def_rw("fade_s", &TaskCycleGains::fade_s, "s, that a change of the stack, the skin or a patch takes")
      .def_rw("feet", &TaskCycleGains::feet, "Foot of a robot that stands on them; none: it is mounted")
      .def_rw("fusion_ends_s", &TaskCycleGains::fusion_ends_s,
              "after which a clock ends the fusion of a period, on a real robot's ports alone; 0: none does");
  nb::class_<robot::FusionCounts>(module, "FusionCounts", "How the ticks of quadratic programmes ended so far.")
      .def_ro("fallback_ticks", &robot::FusionCounts::fallback_ticks,
              "their solver steps, or their time, ended before all levels were exact")
      .def_ro("clock_ticks", &robot::FusionCounts::clock_ticks, "those that the clock ended")
      .def_ro("fade_limited_ticks", &robot::FusionCounts::fade_limited_ticks,
              "a limit forbade that the torque went on without a step")
      .def_ro("widened_ticks", &robot::FusionCounts::widened_ticks,
              "no torque kept all limits, so that those of acceleration gave way")
      .def_ro("most_steps", &robot::FusionCounts::most_steps, "of one tick");
  nb::class_<TaskCycle>(
      module, "TaskCycle",
      "Any behaviour: joint state and skin state in, the tasks of a stack fused, joint command out.\n\n"
      "Requests may come from any thread, those for a stack from one; step belongs to one.")
      .def(
          "__init__",
          [](TaskCycle* self, const RobotModel& model, const skin::SkinModel& skin, TaskCycleGains gains,
             robot::GuardLimits limits, std::vector<StackEntry> entries, Fusion fusion, Damping damping,
             std::optional<QuadraticLimits> quadratic) {
            auto stack = std::make_unique<TaskStack>(model.joint_count(), std::move(entries), fusion, damping,
                                                     std::move(quadratic));
            new (self) TaskCycle(model, skin, std::move(gains), limits, std::move(stack));
          },
          "robot"_a, "skin"_a, "gains"_a, "limits"_a, "entries"_a, "fusion"_a, "damping"_a = Damping{},
          "quadratic"_a = nb::none(), "Raises ModelError, ControlError or GuardError for what does not fit together.")
      .def(
          "step",
          [](TaskCycle& self, const JointState& joints, const skin::SkinState& skin, std::int64_t now_ns,
             JointCommand& command, const skin::SkinTorque* skin_computed_torque) -> const GuardReport& {
            require_joints(self.joint_count(), joints, command);
            return self.step(joints, skin, now_ns, command, skin_computed_torque);
          },
          "joints"_a, "skin"_a, "now_ns"_a, "command"_a, "skin_computed_torque"_a = nb::none(),
          nb::rv_policy::reference_internal,
          "One period. Fills the command, which goes to the robot if the report says send. `skin_computed_torque`: "
          "what the skin "
          "has computed itself.")
      .def(
          "time_steps",
          [](TaskCycle& self, std::vector<std::shared_ptr<JointState>> joints, skin::SkinState& skin,
             std::int64_t start_ns, JointCommand& command, std::size_t steps) {
            if (joints.empty()) throw std::invalid_argument("there must be a joint state");
            for (const auto& state : joints) require_joints(self.joint_count(), *state, command);
            // The processor's time of this thread tells what the period costs where others use the machine, too.
            const auto processor_ns = [] {
              timespec now{};
              clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
              return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
            };
            std::vector<std::int64_t> times(2 * steps);
            for (std::size_t i = 0; i < steps; ++i) {
              const std::int64_t now_ns = start_ns + static_cast<std::int64_t>(i) * 1'000'000;
              JointState& state = *joints[i % joints.size()];
              state.stamp_ns = skin.time_ns = now_ns;
              const std::int64_t processor_before = processor_ns();
              const auto before = std::chrono::steady_clock::now();
              self.step(state, skin, now_ns, command);
              times[2 * i] = std::chrono::nanoseconds(std::chrono::steady_clock::now() - before).count();
              times[2 * i + 1] = processor_ns() - processor_before;
            }
            return copy_of(std::span<const std::int64_t>(times), {steps, 2});
          },
          "joints"_a, "skin"_a, "start_ns"_a, "command"_a, "steps"_a,
          "(steps, 2) nanoseconds on the clock and of the processor that each of as many periods took, on the joint "
          "states "
          "in turn.")
      .def("request_run", &TaskCycle::request_run, "run"_a, "To run, or to stop smoothly.")
      .def("request_mode", nb::overload_cast<CommandMode>(&TaskCycle::request_mode), "mode"_a,
           "The interface of all joints from the next period on.")
      .def(
          "request_modes",
          [](TaskCycle& self, const std::vector<CommandMode>& modes) {
            if (!self.request_mode(std::span<const CommandMode>(modes)))
              throw std::invalid_argument("there must be one mode a joint");
          },
          "modes"_a, "(n) the interface of each joint from the next period on.")
      .def(
          "request_speed_cap",
          [](TaskCycle& self, double share) {
            if (!(share > 0 && share <= 1)) throw std::invalid_argument("share must be above 0 and at most 1");
            self.request_speed_cap(share);
          },
          "share"_a,
          "Of the velocity limits, above 0 to 1, that commands may use: for a robot that is not trusted yet.")
      .def_prop_ro("speed_cap", &TaskCycle::speed_cap, "share of the velocity limits that commands may use")
      .def("request_skin_source", &TaskCycle::request_skin_source, "source"_a,
           "Whose torque skin tasks contribute: what the skin says is used while it is fresh.")
      .def("request_skin", &TaskCycle::request_skin, "on"_a, "Off: no task feels any cell.")
      .def("request_patch_mask", &TaskCycle::request_patch_mask, "patch"_a, "masked"_a,
           "Masked: no task feels the cells of this patch. False if there is no such patch.")
      .def("request_cell_mask", &TaskCycle::request_cell_mask, "cell"_a, "masked"_a,
           "Masked: no task feels this cell, and it counts as not alive. False if there is no such cell.")
      .def(
          "request_stack",
          [](TaskCycle& self, std::vector<StackEntry> entries, Fusion fusion, Damping damping,
             std::optional<QuadraticLimits> quadratic) {
            self.request_stack(std::make_unique<TaskStack>(self.joint_count(), std::move(entries), fusion, damping,
                                                           std::move(quadratic)));
          },
          "entries"_a, "fusion"_a, "damping"_a = Damping{}, "quadratic"_a = nb::none(),
          "The tasks from the next period on; those that stay go on as they are. The torque does not jump.")
      .def_prop_ro("joint_count", &TaskCycle::joint_count, "n")
      .def_prop_ro("standing", &TaskCycle::standing, nb::rv_policy::reference_internal,
                   "StandingState of the last tick; None of a robot that is mounted")
      .def_prop_ro("cell_count", &TaskCycle::cell_count, "N")
      .def_prop_ro("patch_count", &TaskCycle::patch_count, "of the skin")
      .def_prop_ro(
          "touch_torque", [](const TaskCycle& self) { return copy_of(self.touch_torque()); }, nb::rv_policy::move,
          "(n) Nm of the forces felt")
      .def_prop_ro(
          "fused_torque", [](const TaskCycle& self) { return copy_of(self.fused_torque()); }, nb::rv_policy::move,
          "(n) Nm")
      .def_prop_ro("log", log_of,
                   "The last second: 'time_ns', 'state', 'mode' (ticks), 'values' (ticks, 4, n) position, velocity, "
                   "fused torque and command. It ends where a fault stopped the robot.")
      .def_prop_ro(
          "intervention_counts", [](const TaskCycle& self) { return counts_of(self.guard()); }, nb::rv_policy::move,
          "(5, n) cycles in which each `Limit` of each joint changed a running command")
      .def_prop_ro("fusion_counts", &TaskCycle::fusion_counts, nb::rv_policy::reference_internal, "FusionCounts")
      .def_prop_ro("report", &TaskCycle::report, nb::rv_policy::reference_internal, "GuardReport of the last period");
}

}  // namespace robotskin::bindings
