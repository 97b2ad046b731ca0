// SPDX-License-Identifier: Apache-2.0
// Binds packing, checksums, tags and the receiver of frames, for tests that speak to firmware frame by frame.
#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <array>
#include <string>

#include "bindings/firmware_bytes.hpp"
#include "bindings/lab.hpp"
#include "robotskin/chaskey.h"
#include "robotskin/crc.h"
#include "robotskin/keys.h"
#include "robotskin/receiver.h"
#include "robotskin/wire.h"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

template <typename Frame, typename Pack>
nb::bytes packed(const Frame& frame, Pack pack) {
  std::array<std::uint8_t, RS_FRAME_BYTES> bytes{};
  pack(bytes.data(), &frame);
  rs_frame_seal(bytes.data());
  return as_bytes(bytes.data(), bytes.size());
}

template <typename Value>
Value field_value(const nb::dict& fields, const char* frame, const char* name, bool is_signed, unsigned bits) {
  if (!fields.contains(name)) return 0;
  const auto value = nb::cast<std::int64_t>(fields[name]);
  const std::int64_t low = is_signed ? -(std::int64_t{1} << (bits - 1)) : 0;
  const std::int64_t high = (std::int64_t{1} << (is_signed ? bits - 1 : bits)) - 1;
  if (value < low || value > high) {
    throw nb::value_error((std::string(frame) + "." + name + " = " + std::to_string(value) + " is not in " +
                           std::to_string(low) + " to " + std::to_string(high))
                              .c_str());
  }
  return static_cast<Value>(value);
}

void require_known_fields(const nb::dict& fields, const nb::dict& known, const char* frame) {
  for (const auto& [name, value] : fields) {
    if (!known.contains(name)) {
      throw nb::value_error((std::string(frame) + " has no field " + nb::cast<std::string>(name)).c_str());
    }
  }
}

// Fills `type` by itself; fields left out are zero.
nb::bytes pack_frame(const std::string& name, const nb::dict& fields) {
#define SET_FIELD(field, is_signed, bits, text) \
  known[#field] = true;                         \
  frame.field = field_value<decltype(frame.field)>(fields, frame_name, #field, (is_signed) != 0, bits);
#define PACK_FRAME(frame_type, number, text)                          \
  if (name == #frame_type) {                                          \
    constexpr const char* frame_name = #frame_type;                   \
    nb::dict known;                                                   \
    rs_##frame_type frame{};                                          \
    SET_##frame_type require_known_fields(fields, known, frame_name); \
    frame.type = number;                                              \
    return packed(frame, rs_##frame_type##_pack);                     \
  }
#define SET_clock RS_CLOCK_FIELDS(SET_FIELD)
#define SET_event RS_EVENT_FIELDS(SET_FIELD)
#define SET_tick RS_TICK_FIELDS(SET_FIELD)
#define SET_status RS_STATUS_FIELDS(SET_FIELD)
#define SET_grant RS_GRANT_FIELDS(SET_FIELD)
#define SET_joints RS_JOINTS_FIELDS(SET_FIELD)
#define SET_torque RS_TORQUE_FIELDS(SET_FIELD)
#define SET_topology RS_TOPOLOGY_FIELDS(SET_FIELD)
#define SET_command RS_COMMAND_FIELDS(SET_FIELD)
#define SET_reply RS_REPLY_FIELDS(SET_FIELD)
#define SET_join RS_JOIN_FIELDS(SET_FIELD)
#define SET_further RS_FURTHER_FIELDS(SET_FIELD)
#define SET_key RS_KEY_FIELDS(SET_FIELD)
  RS_FRAME_TYPES(PACK_FRAME)
  throw nb::value_error(("no frame is called " + name + "; FRAMES lists those that are").c_str());
}

std::pair<std::string, nb::dict> unpack_frame(const nb::bytes& bytes) {
  const std::uint8_t* data = exactly(bytes, RS_FRAME_BYTES, "a frame");
  if (!rs_frame_intact(data)) throw nb::value_error("the frame's checksum is wrong");
  nb::dict fields;
#define GET_FIELD(field, is_signed, bits, text) fields[#field] = frame.field;
#define UNPACK_FRAME(frame_type, number, text)     \
  case number: {                                   \
    rs_##frame_type frame;                         \
    rs_##frame_type##_unpack(&frame, data);        \
    GET_##frame_type return {#frame_type, fields}; \
  }
#define GET_clock RS_CLOCK_FIELDS(GET_FIELD)
#define GET_event RS_EVENT_FIELDS(GET_FIELD)
#define GET_tick RS_TICK_FIELDS(GET_FIELD)
#define GET_status RS_STATUS_FIELDS(GET_FIELD)
#define GET_grant RS_GRANT_FIELDS(GET_FIELD)
#define GET_joints RS_JOINTS_FIELDS(GET_FIELD)
#define GET_torque RS_TORQUE_FIELDS(GET_FIELD)
#define GET_topology RS_TOPOLOGY_FIELDS(GET_FIELD)
#define GET_command RS_COMMAND_FIELDS(GET_FIELD)
#define GET_reply RS_REPLY_FIELDS(GET_FIELD)
#define GET_join RS_JOIN_FIELDS(GET_FIELD)
#define GET_further RS_FURTHER_FIELDS(GET_FIELD)
#define GET_key RS_KEY_FIELDS(GET_FIELD)
  switch (static_cast<int>(rs_frame_type_of(data))) {
    RS_FRAME_TYPES(UNPACK_FRAME)
    default:
      throw nb::value_error(("no frame has type " + std::to_string(data[0] >> 4)).c_str());
  }
}

void bind_frames(nb::module_& module) {
  module.def("pack", &pack_frame, "frame"_a, "fields"_a,
             "A frame of 20 bytes with its checksum; `fields` maps field names to numbers, those left out are 0. "
             "Raises ValueError for an unknown frame or field and for a number out of its range.");
  module.def("unpack", &unpack_frame, "frame"_a,
             "Name and fields of a frame of 20 bytes. Raises ValueError for another length, a wrong checksum or an "
             "unknown type.");
  module.def(
      "crc16",
      [](const nb::bytes& bytes) {
        return rs_crc16(static_cast<const std::uint8_t*>(bytes.data()), static_cast<std::uint32_t>(bytes.size()));
      },
      "bytes"_a, "Checksum of frames (crc.h).");
  module.def(
      "take_hop",
      [](const nb::bytes& bytes) -> nb::object {
        std::array<std::uint8_t, RS_FRAME_BYTES> frame;
        std::copy_n(exactly(bytes, RS_FRAME_BYTES, "a frame"), frame.size(), frame.begin());
        if (!rs_frame_take_hop(frame.data())) return nb::none();
        return as_bytes(frame.data(), frame.size());
      },
      "frame"_a, "The frame with one hop less to live, or None if it has none left or never had.");
  module.def(
      "cell_keys",
      [](const nb::bytes& secret, std::uint32_t uid) {
        std::array<std::uint8_t, RS_CELL_KEYS_BYTES> keys;
        rs_cell_keys(exactly(secret, RS_CELL_KEY_BYTES, "a secret"), uid, keys.data());
        return as_bytes(keys.data(), keys.size());
      },
      "secret"_a, "uid"_a, "What a cell is made with, from the secret of its section units (keys.h).");
  module.def(
      "chaskey",
      [](const nb::bytes& key, const nb::bytes& message) {
        rs_chaskey_key expanded;
        rs_chaskey_key_expand(&expanded, exactly(key, RS_CHASKEY_KEY_BYTES, "a key"));
        std::array<std::uint8_t, RS_CHASKEY_TAG_BYTES> tag;
        rs_chaskey(&expanded, static_cast<const std::uint8_t*>(message.data()),
                   static_cast<std::uint32_t>(message.size()), tag.data());
        return as_bytes(tag.data(), tag.size());
      },
      "key"_a, "message"_a, "Chaskey-12 tag of 16 bytes (ISO/IEC 29192-6) under a key of 16 bytes.");
}

void bind_receiver(nb::module_& module) {
  nb::class_<rs_receiver>(module, "Receiver", "Finds frames in the bytes of a line (receiver.h).")
      .def("__init__", [](rs_receiver* self) { new (self) rs_receiver{}; })
      .def(
          "feed",
          [](rs_receiver& self, const nb::bytes& bytes) {
            nb::list frames;
            const auto* data = static_cast<const std::uint8_t*>(bytes.data());
            for (std::size_t i = 0; i < bytes.size(); ++i) {
              std::array<std::uint8_t, RS_FRAME_BYTES> frame;
              if (rs_receiver_byte(&self, data[i], frame.data()) == RS_RECEIVED_FRAME) {
                frames.append(as_bytes(frame.data(), frame.size()));
              }
            }
            return frames;
          },
          "bytes"_a, "The frames that these bytes complete.")
      .def(
          "idle", [](rs_receiver& self) { return rs_receiver_idle(&self); },
          "Two byte times of silence: the next byte starts a frame. Returns whether one was cut short.");
}

}  // namespace

void bind_firmware_parts(nb::module_ module) {
  bind_frames(module);
  bind_receiver(module);
  bind_firmware_cell(module);
  bind_firmware_section_unit(module);
}

}  // namespace robotskin::bindings
