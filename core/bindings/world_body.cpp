// SPDX-License-Identifier: Apache-2.0
// Binds the simulated body.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>

#include "bindings/world.hpp"
#include "world/body.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using world::Body;
using world::Carrier;
using world::Hand;
using world::HandDescription;
using world::Imperfections;
using world::ServoGains;
using world::SimulatedRobot;
using world::Waypoint;
using Neighbours = std::vector<std::array<int, 4>>;
using Poses = nb::ndarray<const double, nb::shape<-1, 4, 4>, nb::c_contig, nb::device::cpu>;

template <typename Row>
auto rows(const std::vector<Row>& values) {
  constexpr std::size_t width = std::tuple_size_v<Row>;
  auto* data = new double[values.size() * width + 1];
  for (std::size_t i = 0; i < values.size(); ++i)
    for (std::size_t k = 0; k < width; ++k) data[i * width + k] = values[i][k];
  nb::capsule owner(data, [](void* memory) noexcept { delete[] static_cast<double*>(memory); });
  return nb::ndarray<nb::numpy, double>(data, {values.size(), width}, owner);
}

world::Mounting mounting_of(const std::vector<int>& cell_body, const std::vector<int>& cell_geom,
                            const Poses& body_from_cell, const Neighbours& cell_neighbours,
                            const std::vector<int>& object_body, const std::vector<double>& object_temperature,
                            const std::vector<double>& object_reflectance, double ambient_temperature,
                            const std::vector<int>& material_geom, const std::vector<double>& material_stiffness,
                            const std::vector<bool>& material_local, const std::vector<double>& material_relaxes_by,
                            const std::vector<double>& material_relaxes_in_s, double skin_stiffness) {
  const std::size_t cells = cell_body.size();
  if (cell_geom.size() != cells || body_from_cell.shape(0) != cells ||
      object_body.size() != object_temperature.size() || object_body.size() != object_reflectance.size() ||
      (!cell_neighbours.empty() && cell_neighbours.size() != cells))
    throw std::invalid_argument("Body: one geom and pose a cell, one temperature and reflectance an object");
  if (material_geom.size() != material_stiffness.size() || material_geom.size() != material_local.size() ||
      material_geom.size() != material_relaxes_by.size() || material_geom.size() != material_relaxes_in_s.size())
    throw std::invalid_argument("Body: one stiffness a soft geom");
  world::Mounting mounting;
  mounting.cell_body = cell_body;
  mounting.cell_geom = cell_geom;
  mounting.cell_neighbours = cell_neighbours;
  for (const auto& neighbours : cell_neighbours)
    for (const int neighbour : neighbours)
      if (neighbour >= static_cast<int>(cells)) throw std::invalid_argument("Body: a neighbour that is no cell");
  mounting.object_body = object_body;
  mounting.object_temperature = object_temperature;
  mounting.object_reflectance = object_reflectance;
  mounting.ambient_temperature = ambient_temperature;
  mounting.material_geom = material_geom;
  mounting.material_stiffness_n_per_m = material_stiffness;
  mounting.material_local.assign(material_local.begin(), material_local.end());
  mounting.material_relaxes_by = material_relaxes_by;
  mounting.material_relaxes_in_s = material_relaxes_in_s;
  mounting.skin_stiffness_n_per_m = skin_stiffness;
  for (std::size_t i = 0; i < cells; ++i) {
    const double* m = body_from_cell.data() + 16 * i;
    mounting.body_from_cell_rotation.push_back({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    mounting.body_from_cell_translation.push_back({m[3], m[7], m[11]});
  }
  return mounting;
}

void bind_parts(nb::module_& module) {
  auto imperfections = nb::class_<Imperfections>(
      module, "Imperfections",
      "How far robot, sensors and camera are from what estimators assume; 0 switches one off.");
  imperfections.def(nb::init<>())
      .def_static("ideal", &Imperfections::ideal, "Noise, offset, scale and drift of sensors; all else as modelled.")
      .def_static("none", &Imperfections::none, "Ideal sensors: quantised and limited, nothing else.")
      .def_static(
          "table",
          [] {
            nb::list rows;
            for (const auto& row : world::imperfection_table)
              rows.append(nb::make_tuple(row.name, row.unit, row.meaning, row.source));
            return rows;
          },
          "(name, unit, what it is, source) of each.");
#define ROW(name, value, ideal, unit, meaning, source) imperfections.def_rw(#name, &Imperfections::name, meaning);
  ROBOTSKIN_IMPERFECTIONS(ROW)
#undef ROW

  nb::class_<ServoGains>(module, "ServoGains", "Inner position loop: C v + g + M (kp e + kd de/dt + ki integral e).")
      .def(nb::init<>())
      .def_rw("stiffness", &ServoGains::stiffness, "1/s^2")
      .def_rw("damping", &ServoGains::damping, "1/s")
      .def_rw("integral", &ServoGains::integral, "1/s^3");

  nb::class_<HandDescription>(module, "HandDescription", "A weightless ball on three sliding joints of the world.")
      .def(
          "__init__",
          [](HandDescription* self, int body, int joint, double radius_m, double mass_kg,
             std::array<double, 3> parking) { new (self) HandDescription{body, joint, radius_m, mass_kg, parking}; },
          "body"_a, "joint"_a, "radius_m"_a, "mass_kg"_a, "parking"_a)
      .def_ro("radius_m", &HandDescription::radius_m, "m, of the ball")
      .def_ro("mass_kg", &HandDescription::mass_kg, "kg, that it moves with");

  nb::class_<Waypoint>(module, "Waypoint", "Where a carried thing is at a time of its path.")
      .def(
          "__init__",
          [](Waypoint* self, double time_s, std::array<double, 3> position_m, std::array<double, 4> orientation) {
            new (self) Waypoint{time_s, position_m, orientation};
          },
          "time_s"_a, "position_m"_a, "orientation"_a);

  nb::class_<Carrier>(module, "Carrier", "A thing that goes its way whatever it meets.")
      .def(nb::init<int, std::vector<Waypoint>, bool, bool, double>(), "joint"_a, "path"_a, "smooth"_a, "repeats"_a,
           "begin_s"_a);

  nb::enum_<Hand::Task>(module, "HandTask", "What a hand is doing.")
      .value("parked", Hand::Task::parked)
      .value("approaching", Hand::Task::approaching)
      .value("pushing", Hand::Task::pushing)
      .value("leaving", Hand::Task::leaving);

  nb::class_<SimulatedRobot, RobotPort>(module, "SimulatedRobot",
                                        "A robot that exists in MuJoCo only, behind the port of a real one.");
}

}  // namespace

void bind_world_body(nb::module_& module) {
  bind_parts(module);
  nb::class_<Body> body(module, "Body", "Robot, cells, hands and objects in one MuJoCo model, shared with Python.");
  body.def(
          "__init__",
          [](Body* self, std::uintptr_t model, std::uintptr_t data, const nb::object& /*owner*/,
             const std::vector<int>& cell_body, const std::vector<int>& cell_geom, Poses body_from_cell,
             const Neighbours& cell_neighbours, const std::vector<int>& object_body,
             const std::vector<double>& object_temperature, const std::vector<double>& object_reflectance,
             double ambient_temperature, const std::vector<int>& material_geom,
             const std::vector<double>& material_stiffness, const std::vector<bool>& material_local,
             const std::vector<double>& material_relaxes_by, const std::vector<double>& material_relaxes_in_s,
             double skin_stiffness, const std::vector<HandDescription>& hands, const std::vector<Carrier>& carriers,
             const std::vector<int>& robot_joints, const std::vector<double>& effort_limit, const ServoGains& gains,
             const Imperfections& imperfections, std::uint64_t seed, PortSensors sensors, std::vector<int> imu_body,
             std::vector<int> force_body, std::size_t base_joints) {
            if (sensors.imus.size() != imu_body.size() || sensors.forces.size() != force_body.size())
              throw std::invalid_argument("Body: one body a sensor");
            if (robot_joints.size() != effort_limit.size())
              throw std::invalid_argument("Body: one effort limit a joint");
            new (self)
                Body(reinterpret_cast<mjModel_*>(model), reinterpret_cast<mjData_*>(data),
                     mounting_of(cell_body, cell_geom, body_from_cell, cell_neighbours, object_body, object_temperature,
                                 object_reflectance, ambient_temperature, material_geom, material_stiffness,
                                 material_local, material_relaxes_by, material_relaxes_in_s, skin_stiffness),
                     hands, carriers, robot_joints, effort_limit, gains, imperfections, seed,
                     {std::move(sensors), std::move(imu_body), std::move(force_body)}, base_joints);
          },
          nb::keep_alive<1, 4>(), "model_address"_a, "data_address"_a, "owner"_a, "cell_body"_a, "cell_geom"_a,
          "body_from_cell"_a, "cell_neighbours"_a, "object_body"_a, "object_temperature"_a, "object_reflectance"_a,
          "ambient_temperature"_a, "material_geom"_a, "material_stiffness"_a, "material_local"_a,
          "material_relaxes_by"_a, "material_relaxes_in_s"_a, "skin_stiffness"_a, "hands"_a, "carriers"_a,
          "robot_joints"_a, "effort_limit"_a, "gains"_a, "imperfections"_a, "seed"_a, "sensors"_a = PortSensors{},
          "imu_body"_a = std::vector<int>{}, "force_body"_a = std::vector<int>{}, "base_joints"_a = 0)
      .def("step", &Body::step, "time_ns"_a, "One physics step from this time on.")
      .def_prop_ro("robot", &Body::robot, nb::rv_policy::reference_internal, "the port of the simulated robot")
      .def_prop_ro(
          "sensor_force", [](const Body& self) { return rows(self.contacts().sensor_force()); }, nb::rv_policy::move,
          "(N, 3) newton, what each force sensor truly feels")
      .def_prop_ro(
          "object_force", [](const Body& self) { return self.contacts().object_force(); },
          "(O) newton, MuJoCo's normal contact force of each object on all cells")
      .def_prop_ro(
          "specific_force",
          [](const Body& self) {
            std::vector<std::array<double, 3>> all;
            for (std::size_t i = 0; i < self.cell_count(); ++i) all.push_back(self.truth(i, 0).specific_force);
            return rows(all);
          },
          nb::rv_policy::move, "(N, 3) m/s^2 in each cell's frame")
      .def(
          "distance",
          [](const Body& self) {
            std::vector<std::array<double, 1>> all;
            for (std::size_t i = 0; i < self.cell_count(); ++i) all.push_back({self.truth(i, 0).distance_m});
            return rows(all);
          },
          nb::rv_policy::move, "(N, 1) metres to what reflects most, inf where nothing within reach does")
      .def(
          "temperature",
          [](const Body& self, std::int64_t time_ns) {
            std::vector<std::array<double, 2>> all;
            for (std::size_t i = 0; i < self.cell_count(); ++i) {
              const auto truth = self.truth(i, time_ns);
              all.push_back({truth.board_temperature_c, truth.surface_temperature_c});
            }
            return rows(all);
          },
          "time_ns"_a, nb::rv_policy::move, "(N, 2) degrees Celsius of board and surface")
      .def(
          "sample",
          [](Body& self, std::size_t cell, std::int64_t time_ns) {
            if (cell >= self.cell_count()) throw std::out_of_range("Body.sample: no such cell");
            rs_sample sample;
            self.sample(cell, time_ns, sample);
            return std::vector<int>(sample.value, sample.value + RS_CHANNEL_COUNT);
          },
          "cell"_a, "time_ns"_a, "The nine channels in counts, imperfections included.")
      .def(
          "sample_all",
          [](Body& self, std::int64_t time_ns) {
            const std::size_t cells = self.cell_count();
            auto* counts = new std::int32_t[cells * RS_CHANNEL_COUNT + 1];
            nb::capsule owner(counts, [](void* memory) noexcept { delete[] static_cast<std::int32_t*>(memory); });
            for (std::size_t i = 0; i < cells; ++i) {
              rs_sample sample;
              self.sample(i, time_ns, sample);
              std::copy_n(sample.value, RS_CHANNEL_COUNT, counts + i * RS_CHANNEL_COUNT);
            }
            return nb::ndarray<nb::numpy, std::int32_t>(counts, {cells, std::size_t{RS_CHANNEL_COUNT}}, owner);
          },
          "time_ns"_a, nb::rv_policy::move, "(N, 9) counts of all cells at once.")
      .def(
          "world_from_cell",
          [](const Body& self) {
            std::vector<std::array<double, 16>> all;
            for (std::size_t i = 0; i < self.cell_count(); ++i) all.push_back(self.world_from_cell(i));
            return rows(all);
          },
          nb::rv_policy::move, "(N, 16) metres, a row-major placement of each cell.")
      .def_prop_ro(
          "samples", [](const Body& self) { return self.sensors().samples(); }, "taken by all cells so far")
      .def_prop_ro(
          "saturated_samples", [](const Body& self) { return self.sensors().saturated_samples(); },
          "of them, with a channel at its end")
      .def(
          "carrier_follow",
          [](Body& self, std::size_t carrier, std::vector<Waypoint> path, bool smooth, bool repeats, double begin_s) {
            self.carriers().at(carrier).follow(std::move(path), smooth, repeats, begin_s);
          },
          "carrier"_a, "path"_a, "smooth"_a, "repeats"_a, "begin_s"_a,
          "Sends a carried thing on another path, a list of Waypoint, from virtual time `begin_s` on.")
      .def(
          "hand_push",
          [](Body& self, std::size_t hand, std::size_t cell, double force_n, double x_m, double y_m) {
            self.hands().at(hand).push(cell, force_n, x_m, y_m);
          },
          "hand"_a, "cell"_a, "force_n"_a, "x_m"_a, "y_m"_a,
          "Pushes with so many newton along the inward normal, at the point (x, y) of the cell's face.")
      .def(
          "hand_approach",
          [](Body& self, std::size_t hand, std::size_t cell, double distance_m, double speed_m_s, double x_m,
             double y_m) { self.hands().at(hand).approach(cell, distance_m, speed_m_s, x_m, y_m); },
          "hand"_a, "cell"_a, "distance_m"_a, "speed_m_s"_a, "x_m"_a, "y_m"_a,
          "Comes so near to the point (x, y) of the cell's face, with at most `speed_m_s`.")
      .def(
          "hand_leave", [](Body& self, std::size_t hand) { self.hands().at(hand).leave(); }, "hand"_a,
          "Goes back along the normal, and parks.")
      .def(
          "hand_task", [](Body& self, std::size_t hand) { return self.hands().at(hand).task(); }, "hand"_a, "HandTask.")
      .def(
          "hand_cell", [](Body& self, std::size_t hand) { return self.hands().at(hand).cell(); }, "hand"_a,
          "Index of the cell that it was last sent to.");
  bind_world_sensors(module, body);
}

}  // namespace robotskin::bindings
