// SPDX-License-Identifier: Apache-2.0
// Binds the simulated sensors: what may be wrong with them, and their models without a body around them.
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>

#include "bindings/arrays.hpp"
#include "bindings/world.hpp"
#include "world/body.hpp"
#include "world/sensors.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace robotskin::bindings {
namespace {

using world::Body;
using world::SensorFault;
using world::SensorFaultKind;
using world::Sensors;
template <typename Shape>
using Truths = nb::ndarray<const double, Shape, nb::c_contig, nb::device::cpu>;

SensorFault fault_of(SensorFaultKind kind, const std::vector<int>& channels, double size, double begin_s,
                     std::array<double, 9> turn) {
  SensorFault fault{.kind = kind, .size = size, .begin_s = begin_s, .turn = turn};
  for (const int channel : channels) {
    if (channel < 0 || channel >= RS_CHANNEL_COUNT) throw std::invalid_argument("sensor fault: no such channel");
    fault.channels |= 1U << channel;
  }
  return fault;
}

constexpr std::array<double, 9> no_turn{1, 0, 0, 0, 1, 0, 0, 0, 1};
constexpr const char* fault_doc =
    R"(What is wrong with a cell from `begin_s` on: its kind, the channels 0 to 8 that it is of, its size in newton, g, share of
full scale or K (see SensorFaultKind), and of a loose cell the row-major turn that maps its frame now to the one it had.)";

std::array<double, 3> row_of(const double* rows, std::size_t row) {
  return {rows[3 * row], rows[3 * row + 1], rows[3 * row + 2]};
}

}  // namespace

void bind_world_sensors(nb::module_& module, nb::class_<Body>& body) {
  nb::enum_<SensorFaultKind>(module, "SensorFaultKind", "What may go wrong with the sensors of a cell.")
#define ROW(name, unit, meaning) .value(#name, SensorFaultKind::name, meaning)
      ROBOTSKIN_SENSOR_FAULTS(ROW)
#undef ROW
          ;
  body.def(
          "set_sensor_fault",
          [](Body& self, std::size_t cell, SensorFaultKind kind, const std::vector<int>& channels, double size,
             double begin_s, std::array<double, 9> turn) {
            self.set_sensor_fault(cell, fault_of(kind, channels, size, begin_s, turn));
          },
          "cell"_a, "kind"_a, "channels"_a = std::vector<int>{}, "size"_a = 0.0, "begin_s"_a = 0.0, "turn"_a = no_turn,
          fault_doc)
      .def("swap_cells", &Body::swap_cells, "one"_a, "other"_a, "Each is found in the other's place from now on.");
  nb::class_<Sensors>(module, "SensorModels", "The nine channels of N cells without a robot: truth in, counts out.")
      .def(nb::init<std::size_t, const world::Imperfections&, std::uint64_t>(), "cells"_a, "imperfections"_a, "seed"_a)
      .def(
          "set_fault",
          [](Sensors& self, std::size_t cell, SensorFaultKind kind, const std::vector<int>& channels, double size,
             double begin_s,
             std::array<double, 9> turn) { self.set_fault(cell, fault_of(kind, channels, size, begin_s, turn)); },
          "cell"_a, "kind"_a, "channels"_a = std::vector<int>{}, "size"_a = 0.0, "begin_s"_a = 0.0, "turn"_a = no_turn,
          fault_doc)
      .def(
          "sample",
          [](Sensors& self, double time_s, Truths<nb::shape<-1, 3>> force_n, Truths<nb::shape<-1>> distance_m,
             Truths<nb::shape<-1>> reflectance, Truths<nb::shape<-1, 3>> specific_force,
             Truths<nb::shape<-1, 2>> temperature_c) {
            const std::size_t cells = force_n.shape(0);
            if (distance_m.shape(0) != cells || reflectance.shape(0) != cells || specific_force.shape(0) != cells ||
                temperature_c.shape(0) != cells || cells != self.cell_count())
              throw std::invalid_argument("SensorModels: a row a cell");
            std::vector<std::int32_t> counts(cells * RS_CHANNEL_COUNT);
            for (std::size_t cell = 0; cell < cells; ++cell) {
              const double* celsius = temperature_c.data() + 2 * cell;
              const world::Truth truth{row_of(force_n.data(), cell),
                                       distance_m.data()[cell],
                                       reflectance.data()[cell],
                                       row_of(specific_force.data(), cell),
                                       celsius[1],
                                       celsius[0]};
              rs_sample sample;
              self.sample(cell, time_s, truth, sample);
              std::copy_n(sample.value, RS_CHANNEL_COUNT, counts.data() + cell * RS_CHANNEL_COUNT);
            }
            return copy_of(std::span<const std::int32_t>(counts), {cells, std::size_t{RS_CHANNEL_COUNT}});
          },
          "time_s"_a, "force_n"_a, "distance_m"_a, "reflectance"_a, "specific_force"_a, "temperature_c"_a,
          nb::rv_policy::move,
          R"((N, 9) counts of all cells at one time, from what is true there: force (N, 3) newton of each sensor, distance
(N) metres, reflectance (N), specific force (N, 3) m/s^2 in the cell frame, temperature (N, 2) of board and surface.)");
}

}  // namespace robotskin::bindings
