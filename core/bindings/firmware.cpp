// SPDX-License-Identifier: Apache-2.0
// Binds what the firmware headers define: cell geometry, channels, wire format and limits. Python repeats none of it.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "bindings/bindings.hpp"
#include "robotskin/cell.h"
#include "robotskin/channels.h"
#include "robotskin/commissioning.h"
#include "robotskin/crc.h"
#include "robotskin/datagram.h"
#include "robotskin/geometry.h"
#include "robotskin/operations.h"
#include "robotskin/section_unit.h"
#include "robotskin/settings.h"
#include "robotskin/timing.h"
#include "robotskin/wire.h"

namespace robotskin::bindings {

void bind_firmware_torque(nanobind::module_& module);

namespace {

namespace nb = nanobind;
using namespace nb::literals;

using Points = nb::ndarray<nb::numpy, const double, nb::shape<-1, 2>>;

#define POINT_METRES(port, x_um, y_um) {(x_um) * 1e-6, (y_um) * 1e-6},
constexpr double port_points_m[][2] = {RS_PORT_POINTS(POINT_METRES)};
constexpr double force_sensor_points_m[][2] = {RS_FORCE_SENSOR_POINTS(POINT_METRES)};
#undef POINT_METRES

void bind_geometry(nb::module_& module) {
  module.attr("PORT_POINTS_M") = nb::cast(Points(port_points_m, {RS_PORTS, 2}));
  module.attr("FORCE_SENSOR_POINTS_M") = nb::cast(Points(force_sensor_points_m, {3, 2}));
  module.attr("HEXAGON_SIDE_M") = RS_HEXAGON_SIDE_UM * 1e-6;
  module.attr("LATTICE_PITCH_M") = RS_LATTICE_PITCH_UM * 1e-6;
  module.attr("CELL_THICKNESS_M") = RS_CELL_THICKNESS_UM * 1e-6;
  module.attr("HINGE_REACH_M") = RS_HINGE_REACH_UM * 1e-6;
}

void bind_limits(nb::module_& module) {
#define LIMIT(name) module.attr(#name) = static_cast<std::int64_t>(RS_##name);
  LIMIT(ID_FIRST)
  LIMIT(ID_LAST)
  LIMIT(ID_NONE)
  LIMIT(ID_ALL)
  LIMIT(ID_SECTION_UNIT)
  LIMIT(HOPS_POISON)
  LIMIT(TTL_START)
  LIMIT(PORTS)
  LIMIT(FRAME_BYTES)
  LIMIT(CONTENT_BYTES)
  LIMIT(CONTENT_BITS)
  LIMIT(LINK_BAUD)
  LIMIT(LINK_BITS_PER_BYTE)
  LIMIT(CELLS_PER_PORT)
  LIMIT(CRC_POLYNOMIAL)
  LIMIT(CRC_START)
  LIMIT(CELL_KEY_BYTES)
  LIMIT(FLASH_BYTES)
  LIMIT(SECTION_UNIT_PORTS_MAX)
  LIMIT(UNIT_ALL)
  LIMIT(UNIT_NAMES_MAX)
  LIMIT(HOST_PORT)
  LIMIT(SECTION_UNIT_PORT)
  LIMIT(KEEP_ALIVE_MS)
  LIMIT(UNIT_SILENCE_MS)
  LIMIT(DATAGRAM_MAGIC)
  LIMIT(DATAGRAM_VERSION)
  LIMIT(DATAGRAM_HEADER_BYTES)
  LIMIT(DATAGRAM_RECORD_BYTES)
  LIMIT(DATAGRAM_RECORDS_MAX)
  LIMIT(DATAGRAM_TAG_BYTES)
  LIMIT(DATAGRAM_KEY_BYTES)
  LIMIT(DATAGRAM_BYTES_MAX)
  LIMIT(EVENT_RATE_MIN_HZ)
  LIMIT(EVENT_RATE_MAX_HZ)
  LIMIT(EVENT_MASK_ALL)
  LIMIT(FRAME_US)
  LIMIT(TICK_US)
  LIMIT(LINK_UP_FRAMES)
  LIMIT(LINK_DOWN_US)
  LIMIT(QUARANTINE_US)
  LIMIT(STALE_US)
  LIMIT(STALE_LIMIT_US)
  LIMIT(ORPHAN_RESET_US)
  LIMIT(STATUS_US)
  LIMIT(TOPOLOGY_US)
  LIMIT(JOIN_US)
  LIMIT(TAG_FORGIVEN_US)
  LIMIT(FIRMWARE_VERSION)
  LIMIT(TAGS_BUDGET)
  LIMIT(TAGS_CLOSED_S)
  LIMIT(TAGS_TOLD_S)
  LIMIT(UNREAD)
  LIMIT(REFRESH_US)
  LIMIT(REFRESH_JITTER_US)
  LIMIT(FRESH_US)
  LIMIT(ARQ_KEEP_US)
  LIMIT(TORQUE_RETRY_US)
  LIMIT(TORQUE_END_US)
  LIMIT(EPOCH_TICKS)
#undef LIMIT
  module.attr("CELL_STATE_BYTES") = sizeof(rs_cell);
}

// ---- Tables: lists of tuples in the order of the headers ----

void bind_tables(nb::module_& module) {
  nb::list channels, sensors, types, key_steps, operations, statuses, kinds, thresholds, rates;
#define CHANNEL(name, is_signed, bits, numerator, denominator, unit) \
  channels.append(nb::make_tuple(#name, (is_signed) != 0, bits, double{numerator} / (denominator), unit));
  RS_CHANNELS(CHANNEL)
#undef CHANNEL
#define SENSOR(name, is_signed, first, count, column, blank, unit) \
  sensors.append(nb::make_tuple(#name, #column, count, unit, RS_CHANNEL_##first >= RS_CHANNEL_COUNT));
  RS_SENSORS(SENSOR)
#undef SENSOR
#define NUMBERED(name, number, text) types.append(nb::make_tuple(#name, number, text));
  RS_FRAME_TYPES(NUMBERED)
#undef NUMBERED
#define KEY_STEP(name, number, text) key_steps.append(nb::make_tuple(#name, number, text));
  RS_KEY_STEPS(KEY_STEP)
#undef KEY_STEP
#define OPERATION(name, number, index, value) operations.append(nb::make_tuple(#name, number, index, value));
  RS_OPERATIONS(OPERATION)
#undef OPERATION
#define STATUS(name, number, text) statuses.append(nb::make_tuple(#name, number, text));
  RS_REPLY_STATUSES(STATUS)
#undef STATUS
#define KIND(name, number, text) kinds.append(nb::make_tuple(#name, number, text));
  RS_DATAGRAM_KINDS(KIND)
#undef KIND
#define THRESHOLD(channel, counts) thresholds.append(nb::make_tuple(#channel, counts));
  RS_THRESHOLDS(THRESHOLD)
#undef THRESHOLD
#define RATE(rate_hz, period_us) rates.append(nb::make_tuple(rate_hz, period_us));
  RS_CLOCK_RATES(RATE)
#undef RATE
  module.attr("CHANNELS") = nb::tuple(channels);  // name, signed, bits, unit per count, unit
  module.attr("SENSORS") =
      nb::tuple(sensors);  // name, column, channels, unit, whether beyond a sample frame's channels
  module.attr("FRAME_TYPES") = nb::tuple(types);            // name, number, meaning
  module.attr("KEY_STEPS") = nb::tuple(key_steps);          // name, number, meaning
  module.attr("OPERATIONS") = nb::tuple(operations);        // name, number, index, value
  module.attr("REPLY_STATUSES") = nb::tuple(statuses);      // name, number, meaning
  module.attr("DATAGRAM_KINDS") = nb::tuple(kinds);         // name, number, meaning
  module.attr("EVENT_THRESHOLDS") = nb::tuple(thresholds);  // channel, counts
  module.attr("CLOCK_RATES") = nb::tuple(rates);            // Hz as commanded, period in us

  nb::dict frames;
#define FIELD(name, is_signed, bits, text) fields.append(nb::make_tuple(#name, (is_signed) != 0, bits, text));
#define FRAME(type, number, text)                       \
  {                                                     \
    nb::list fields;                                    \
    FIELDS_OF_##type frames[#type] = nb::tuple(fields); \
  }
#define FIELDS_OF_clock RS_CLOCK_FIELDS(FIELD)
#define FIELDS_OF_event RS_EVENT_FIELDS(FIELD)
#define FIELDS_OF_tick RS_TICK_FIELDS(FIELD)
#define FIELDS_OF_status RS_STATUS_FIELDS(FIELD)
#define FIELDS_OF_grant RS_GRANT_FIELDS(FIELD)
#define FIELDS_OF_joints RS_JOINTS_FIELDS(FIELD)
#define FIELDS_OF_torque RS_TORQUE_FIELDS(FIELD)
#define FIELDS_OF_topology RS_TOPOLOGY_FIELDS(FIELD)
#define FIELDS_OF_command RS_COMMAND_FIELDS(FIELD)
#define FIELDS_OF_reply RS_REPLY_FIELDS(FIELD)
#define FIELDS_OF_join RS_JOIN_FIELDS(FIELD)
#define FIELDS_OF_further RS_FURTHER_FIELDS(FIELD)
#define FIELDS_OF_key RS_KEY_FIELDS(FIELD)
  RS_FRAME_TYPES(FRAME)
  module.attr("FRAMES") = frames;  // name: tuples of field name, signed, bits, meaning
}

}  // namespace

void bind_firmware(nb::module_ module) {
  nb::enum_<rs_mode>(module, "CellMode", "When a cell sends its samples.")
      .value("clock", RS_MODE_CLOCK, "at the clock rate")
      .value("event", RS_MODE_EVENT, "when a channel has changed by its threshold, and now and then");
  bind_geometry(module);
  bind_limits(module);
  bind_tables(module);
  bind_firmware_torque(module);
}

}  // namespace robotskin::bindings
