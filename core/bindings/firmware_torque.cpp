// Binds the cell's own arithmetic: sine, touch and the torques of a chain of joints, in the integers of the firmware.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "robotskin/chain.h"
#include "robotskin/touch.h"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

std::int16_t narrow(int value, const char* what) {
  if (value < INT16_MIN || value > INT16_MAX)
    throw nb::value_error((std::string(what) + " " + std::to_string(value) + " does not fit 16 bits").c_str());
  return static_cast<std::int16_t>(value);
}

rs_chain chain_of(const std::vector<std::pair<std::array<int, 9>, std::array<int, 3>>>& places,
                  const std::vector<bool>& prismatic, int length_exponent, const std::array<int, 3>& point,
                  const std::array<int, 3>& direction) {
  if (prismatic.empty() || prismatic.size() > RS_CHAIN_JOINTS || places.size() + 1 != prismatic.size())
    throw nb::value_error("a chain has 1 to 12 joints, and a place for each but the first");
  rs_chain chain{};
  chain.joints = static_cast<std::uint8_t>(prismatic.size());
  chain.length_exponent = static_cast<std::int8_t>(length_exponent);
  for (std::size_t l = 0; l < prismatic.size(); ++l)
    if (prismatic[l]) chain.prismatic = static_cast<std::uint16_t>(chain.prismatic | 1U << l);
  for (std::size_t l = 0; l < places.size(); ++l) {
    for (std::size_t i = 0; i < 9; ++i) chain.place[l].rotation[i] = narrow(places[l].first[i], "rotation element");
    for (std::size_t i = 0; i < 3; ++i) chain.place[l].offset[i] = narrow(places[l].second[i], "offset");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    chain.point[i] = narrow(point[i], "point");
    chain.direction[i] = narrow(direction[i], "direction");
  }
  return chain;
}

}  // namespace

void bind_firmware_torque(nb::module_& module) {
#define LIMIT(name) module.attr(#name) = static_cast<std::int64_t>(RS_##name);
  LIMIT(UNIT_BITS)
  LIMIT(MATRIX_BITS)
  LIMIT(LENGTH_BITS)
  LIMIT(FORCE_BITS)
  LIMIT(TORQUE_BITS)
  LIMIT(TURN)
  LIMIT(CHAIN_JOINTS)
  LIMIT(CHAIN_REACH)
  LIMIT(LENGTH_EXPONENT_MIN)
  LIMIT(LENGTH_EXPONENT_MAX)
  LIMIT(TOUCH_FORCE_LIMIT)
#undef LIMIT
  module.def("sine", &rs_sine, "angle"_a, "Of an angle in 2 pi / TURN rad, times 2^UNIT_BITS.");

  nb::class_<rs_chain>(module, "Chain", "The joints below a cell in the integers that a cell keeps (chain.h).")
      .def(
          "__init__",
          [](rs_chain* self, const std::vector<std::pair<std::array<int, 9>, std::array<int, 3>>>& places,
             const std::vector<bool>& prismatic, int length_exponent, const std::array<int, 3>& point,
             const std::array<int, 3>& direction) {
            new (self) rs_chain(chain_of(places, prismatic, length_exponent, point, direction));
          },
          "places"_a, "prismatic"_a, "length_exponent"_a, "point"_a, "direction"_a,
          "`places`: (rotation, offset) of each joint but the first. Raises ValueError for what does not fit.")
      .def(
          "valid", [](const rs_chain& self, int slide) { return rs_chain_valid(&self, slide); }, "slide"_a = 0,
          "Whether no posture leaves the range of its integers.")
      .def(
          "torque",
          [](const rs_chain& self, const std::vector<int>& position, std::int32_t force) {
            if (position.size() != self.joints) throw nb::value_error("one position a joint");
            if (force < 0) throw nb::value_error("a force is not negative");
            std::int16_t angle[RS_CHAIN_JOINTS];
            for (std::size_t l = 0; l < position.size(); ++l) angle[l] = narrow(position[l], "position");
            std::vector<std::int32_t> torque(self.joints);
            if (!rs_chain_torque(&self, angle, force, torque.data()))
              throw nb::value_error("a torque is beyond 32 bits");
            return torque;
          },
          "position"_a, "force"_a, "Nm (N where a joint slides) times 2^TORQUE_BITS, for a force in N 2^FORCE_BITS.");

  nb::class_<rs_touch_gains>(module, "TouchGains", "Silent, full, weight and weight bits of force and proximity.")
      .def(
          "__init__",
          [](rs_touch_gains* self, const std::array<unsigned, 4>& force, const std::array<unsigned, 4>& proximity) {
            const auto sense = [](const std::array<unsigned, 4>& of) {
              for (std::size_t i = 0; i < 3; ++i)
                if (of[i] > UINT16_MAX) throw nb::value_error("silent, full and weight have 16 bits");
              return rs_sense{static_cast<std::uint16_t>(of[0]), static_cast<std::uint16_t>(of[1]),
                              static_cast<std::uint16_t>(of[2]), static_cast<std::uint8_t>(of[3])};
            };
            new (self) rs_touch_gains{sense(force), sense(proximity)};
          },
          "force"_a, "proximity"_a)
      .def(
          "force",
          [](const rs_touch_gains& self, const std::array<std::int32_t, RS_CHANNEL_COUNT>& values) {
            rs_sample sample;
            std::copy(values.begin(), values.end(), sample.value);
            return rs_touch_force(&self, &sample);
          },
          "sample"_a, "Newton times 2^FORCE_BITS that a sample asks for.");
}

}  // namespace robotskin::bindings
