// SPDX-License-Identifier: Apache-2.0
// Binds the cell's own arithmetic: sine, touch and the torques of a chain of joints, in the integers of the firmware.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "bindings/bindings.hpp"
#include "bindings/firmware_bytes.hpp"
#include "robotskin/torque.h"
#include "robotskin/torque_parameters.h"

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

std::vector<std::int32_t> torque_of(const rs_chain& chain, const std::vector<int>& position, std::int32_t force) {
  if (position.size() != chain.joints) throw nb::value_error("one position a joint");
  if (force < 0) throw nb::value_error("a force is not negative");
  std::int16_t angle[RS_CHAIN_JOINTS];
  for (std::size_t l = 0; l < position.size(); ++l) angle[l] = narrow(position[l], "position");
  std::vector<std::int32_t> torque(chain.joints);
  if (!rs_chain_torque(&chain, angle, force, torque.data())) throw nb::value_error("a torque is beyond 32 bits");
  return torque;
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
      .def("torque", &torque_of, "position"_a, "force"_a,
           "Nm (N where a joint slides) times 2^TORQUE_BITS, for a force in N 2^FORCE_BITS.");

  nb::class_<rs_touch_gains>(module, "TouchGains", "Silent, full, weight and weight bits of force and proximity.")
      .def(
          "__init__",
          [](rs_touch_gains* self, const std::array<unsigned, 4>& force, const std::array<unsigned, 4>& proximity) {
            const auto sense = [](const std::array<unsigned, 4>& of) {
              for (std::size_t i = 0; i < 3; ++i)
                if (of[i] > UINT16_MAX) throw nb::value_error("silent, full and weight have 16 bits");
              return rs_sense{static_cast<std::uint16_t>(of[0]), static_cast<std::uint16_t>(of[1]),
                              static_cast<std::uint16_t>(of[2]), static_cast<std::uint8_t>(of[3]), 0};
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

  module.attr("TORQUE_IMAGE_BYTES") = static_cast<int>(RS_TORQUE_IMAGE_BYTES);
  module.attr("TORQUE_STEP_BITS") = static_cast<int>(RS_TORQUE_STEP_BITS);
  module.attr("TORQUE_AGE_MAX") = static_cast<int>(RS_TORQUE_AGE_MAX);
  nb::class_<rs_torque_parameters>(module, "TorqueParameters",
                                   "What a cell must know to compute its own torque (torque_parameters.h).")
      .def(
          "__init__",
          [](rs_torque_parameters* self, const rs_chain& chain, const rs_touch_gains& gains, unsigned limb,
             unsigned step_bits, unsigned slide) {
            if (limb >= RS_TORQUE_LIMBS) throw nb::value_error("a limb is 0 to 15");
            if (step_bits >= RS_TORQUE_BITS) throw nb::value_error("step bits are 0 to 15");
            if (slide > INT16_MAX) throw nb::value_error("a slide has 15 bits");
            new (self) rs_torque_parameters{chain, gains, static_cast<std::uint16_t>(slide),
                                            static_cast<std::uint8_t>(limb), static_cast<std::uint8_t>(step_bits)};
          },
          "chain"_a, "gains"_a, "limb"_a, "step_bits"_a = static_cast<int>(RS_TORQUE_STEP_BITS), "slide"_a = 0,
          "`slide`: longest way of a sliding joint, 2^-LENGTH_BITS m. Raises ValueError for what cannot be.")
      .def(
          "torque",
          [](const rs_torque_parameters& self, const std::vector<int>& position, std::int32_t force) {
            return torque_of(self.chain, position, force);
          },
          "position"_a, "force"_a, "As of its chain.")
      .def_prop_ro(
          "image",
          [](const rs_torque_parameters& self) {
            std::uint8_t image[RS_TORQUE_IMAGE_BYTES];
            rs_torque_parameters_pack(&self, image);
            return as_bytes(image, sizeof image);
          },
          "as a cell keeps it in its flash")
      .def_prop_ro(
          "words",
          [](const rs_torque_parameters& self) {
            std::uint8_t image[RS_TORQUE_IMAGE_BYTES];
            rs_torque_parameters_pack(&self, image);
            std::vector<std::uint64_t> words;
            const std::size_t bytes = rs_torque_parameters_bytes(image);
            for (std::size_t i = 0; RS_TORQUE_WORD_BYTES * i < bytes; ++i) {
              std::uint64_t word = 0;
              for (std::size_t k = 0; k < RS_TORQUE_WORD_BYTES; ++k)
                word = word << 8 | image[RS_TORQUE_WORD_BYTES * i + k];
              words.push_back(word);
            }
            return words;
          },
          "values of torque_word by index")
      .def_prop_ro(
          "checksum",
          [](const rs_torque_parameters& self) {
            std::uint8_t image[RS_TORQUE_IMAGE_BYTES];
            rs_torque_parameters_pack(&self, image);
            return rs_torque_parameters_checksum(image);
          },
          "value of torque_commit")
      .def_static(
          "valid",
          [](const nb::bytes& image) {
            rs_torque_parameters parameters;
            return rs_torque_parameters_unpack(&parameters,
                                               exactly(image, RS_TORQUE_IMAGE_BYTES, "an image of parameters"));
          },
          "image"_a, "Whether a cell would take an image.");
}

}  // namespace robotskin::bindings
