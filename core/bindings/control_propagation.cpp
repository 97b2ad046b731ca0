// SPDX-License-Identifier: Apache-2.0
// Binds limbs, and the task that hands what a limb cannot give to the one that carries it.
#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings/arrays.hpp"
#include "bindings/bindings.hpp"
#include "bindings/task_input.hpp"
#include "control/propagated_compliance_task.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using control::Contact;
using control::ContactGains;
using control::ContactImpedanceGains;
using control::Limb;
using control::PropagatedComplianceTask;
using control::PropagationGains;

void bind_gains(nb::module_& module) {
  nb::class_<Limb>(module, "Limb", "Joints that belong together, and the limb that takes what they leave undone.")
      .def(
          "__init__",
          [](Limb* self, std::string name, std::vector<std::string> joints, std::string parent,
             std::vector<double> largest_acceleration) {
            new (self) Limb{std::move(name), std::move(joints), std::move(parent), std::move(largest_acceleration)};
          },
          "name"_a, "joints"_a, "parent"_a, "largest_acceleration"_a)
      .def_rw("name", &Limb::name, "of the limb")
      .def_rw("joints", &Limb::joints, "names of its joints")
      .def_rw("parent", &Limb::parent, "name of the limb that carries this one; empty: none does")
      .def_rw("largest_acceleration", &Limb::largest_acceleration, "(joints) rad/s^2 or m/s^2");
  nb::class_<ContactGains>(module, "ContactGains", "How the cells' forces are merged into contacts.")
      .def(nb::init<>())
      .def_rw("merge_within_m", &ContactGains::merge_within_m,
              "cells of a body nearer than this to a contact belong to it; all of them are one if it is large")
      .def_rw("bandwidth_hz", &ContactGains::bandwidth_hz, "Hz, low-pass of force and point")
      .def_rw("fade_s", &ContactGains::fade_s, "s, in which a contact that is over stops counting");
  nb::class_<PropagationGains>(module, "PropagationGains", "Of a PropagatedComplianceTask [Cheng19 eq. 26, 27].")
      .def(nb::init<>())
      .def_rw("impedance", &PropagationGains::impedance, "ContactImpedanceGains of each contact")
      .def_rw("contacts", &PropagationGains::contacts, "ContactGains")
      .def_rw("largest_speed_m_s", &PropagationGains::largest_speed_m_s, "m/s, of the wanted motion of a contact")
      .def_rw("largest_joint_speed", &PropagationGains::largest_joint_speed, "rad/s or m/s")
      .def_rw("largest_lead_m", &PropagationGains::largest_lead_m, "m, by which it may run ahead of the contact")
      .def_rw("tracking_per_s", &PropagationGains::tracking_per_s, "1/s, how fast the contact comes back to it")
      .def_rw("effort", &PropagationGains::effort, "epsilon of [Cheng19 eq. 27]")
      .def_rw("kept_m_s2", &PropagationGains::kept_m_s2,
              "what a limb leaves undone of a contact's acceleration and does not hand on")
      .def_rw("begin_s", &PropagationGains::begin_s, "in which the contacts that there are at the start come to count")
      .def_rw("return_per_s", &PropagationGains::return_per_s, "how fast joints go back to their reference")
      .def_rw("sweeps", &PropagationGains::sweeps, "over all limbs in a tick")
      .def_rw("steps", &PropagationGains::steps, "of the solver, in a tick");
}

void bind_propagated_compliance(nb::module_& module) {
  nb::class_<Contact>(module, "Contact", "A contact, in the frame of the joint that carries its body.")
      .def_ro("joint", &Contact::joint, "index; it carries the body")
      .def_ro("force", &Contact::force, "(3) newton")
      .def_ro("point", &Contact::point, "(3) m")
      .def_ro("share", &Contact::share, "0 to 1, how much it counts");
  nb::class_<PropagatedComplianceTask, control::Task>(
      module, "PropagatedComplianceTask",
      "The whole robot gives way: what a limb cannot do at its contacts is handed to the one that carries it.")
      .def(nb::init<const RobotModel&, const skin::SkinModel&, std::shared_ptr<control::TouchWrench>,
                    const std::vector<Limb>&, PropagationGains>(),
           "robot"_a, "skin"_a, "touch"_a, "limbs"_a, "gains"_a = PropagationGains{},
           "touch: of weight 1, in newton. Raises ControlError for limbs and gains that do not fit.")
      .def_prop_ro(
          "contacts",
          [](const PropagatedComplianceTask& self) {
            std::vector<Contact> found;
            for (const Contact& one : self.contacts())
              if (one.share > 0) found.push_back(one);
            return found;
          },
          "of the last update")
      .def_prop_ro(
          "residuals",
          [](const PropagatedComplianceTask& self) {
            nb::dict found;
            for (std::size_t limb = 0; limb < self.limb_count(); ++limb)
              found[self.limb_name(limb).c_str()] = self.residual(limb);
            return found;
          },
          "m/s^2 by name of the limb: what it has left undone of its contacts' accelerations in the last update")
      .def_prop_ro(
          "acceleration", [](const PropagatedComplianceTask& self) { return copy_of(self.acceleration()); },
          nb::rv_policy::move, "(n) rad/s^2 that the joints are to have");
}

}  // namespace

void bind_control_propagation(nb::module_& module) {
  bind_gains(module);
  bind_propagated_compliance(module);
}

}  // namespace robotskin::bindings
