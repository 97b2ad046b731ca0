// SPDX-License-Identifier: Apache-2.0
#include "bindings/driver_tables.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <string>
#include <vector>

#include "bindings/bytes.hpp"

namespace robotskin::bindings {

namespace nb = nanobind;
using namespace driver;

namespace {

std::string operation_name(unsigned number) {
#define ROBOTSKIN_OPERATION(operation, its_number, index, value) \
  if (number == its_number) return #operation;
  RS_OPERATIONS(ROBOTSKIN_OPERATION)
#undef ROBOTSKIN_OPERATION
  return std::to_string(number);
}

std::string reply_status_name(unsigned number) {
#define ROBOTSKIN_STATUS(status, its_number, text) \
  if (number == its_number) return #status;
  RS_REPLY_STATUSES(ROBOTSKIN_STATUS)
#undef ROBOTSKIN_STATUS
  return std::to_string(number);
}

}  // namespace

nb::dict statistics_dict(const Statistics& statistics) {
  nb::dict dict;
#define ROBOTSKIN_COUNT(name, meaning) dict[#name] = statistics.name.get();
  ROBOTSKIN_DATAGRAM_VERDICTS(ROBOTSKIN_COUNT)
  ROBOTSKIN_DRIVER_COUNTS(ROBOTSKIN_COUNT)
#undef ROBOTSKIN_COUNT
#define ROBOTSKIN_SENSOR_EVENTS(name, ...) dict["events_" #name] = statistics.events_##name.get();
  RS_SENSORS(ROBOTSKIN_SENSOR_EVENTS)
#undef ROBOTSKIN_SENSOR_EVENTS
  return dict;
}

nb::dict samples_dict(SnapshotTable<Sample>& table) {
  const std::span<const Sample> rows = table.read();
  nb::dict dict;
  const auto column = [&]<class Value>(const char* name, std::size_t columns, Value, const auto& value) {
    dict[name] = filled<Value>(rows.size(), columns, [&](std::size_t i, std::size_t c) { return value(rows[i], c); });
  };
  column("key", 1, std::uint32_t{}, [](const Sample& s, std::size_t) { return s.key; });
#define ROBOTSKIN_COLUMN(name, is_signed, first, channels, ...) \
  column(#name, channels, driver::Counts<(is_signed) != 0>{}, [](const Sample& s, std::size_t c) { return s.name[c]; });
  RS_SENSORS(ROBOTSKIN_COLUMN)
#undef ROBOTSKIN_COLUMN
  column("stamp_ns", 1, std::int64_t{}, [](const Sample& s, std::size_t) { return s.stamp_ns; });
  column("arrival_ns", 1, std::int64_t{}, [](const Sample& s, std::size_t) { return s.arrival_ns; });
  column("sequence", 1, std::uint8_t{}, [](const Sample& s, std::size_t) { return s.sequence; });
  column("clock_frames", 1, std::uint32_t{}, [](const Sample& s, std::size_t) { return s.clock_frames; });
  column("event_frames", 1, std::uint32_t{}, [](const Sample& s, std::size_t) { return s.event_frames; });
  column("seen", 1, bool{}, [](const Sample& s, std::size_t) -> bool { return s.seen; });
  column("event", 1, bool{}, [](const Sample& s, std::size_t) -> bool { return s.event; });
  column("fault", 1, bool{}, [](const Sample& s, std::size_t) -> bool { return s.fault; });
  return dict;
}

nb::dict topology_dict(SnapshotTable<TopologyRow>& table, SnapshotTable<Sample>& samples) {
  const std::span<const TopologyRow> rows = table.read();
  const std::span<const Sample> cells = samples.read();
  nb::dict dict;
  const auto column = [&]<class Value>(const char* name, std::size_t columns, Value, const auto& value) {
    dict[name] = filled<Value>(rows.size(), columns, [&](std::size_t i, std::size_t c) { return value(rows[i], c); });
  };
  dict["key"] = filled<std::uint32_t>(cells.size(), 1, [&](std::size_t i, std::size_t) { return cells[i].key; });
  column("heard_ns", 1, std::int64_t{}, [](const TopologyRow& r, std::size_t) { return r.heard_ns; });
  column("uid", 1, std::uint32_t{}, [](const TopologyRow& r, std::size_t) { return r.uid; });
  column("parent_port", 1, std::uint8_t{}, [](const TopologyRow& r, std::size_t) { return r.parent_port; });
  column("closed_port", 1, std::uint8_t{}, [](const TopologyRow& r, std::size_t) { return r.closed_port; });
  column("neighbour_id", RS_PORTS, std::uint16_t{},
         [](const TopologyRow& r, std::size_t c) { return r.neighbours[c].id; });
  column("neighbour_port", RS_PORTS, std::uint8_t{},
         [](const TopologyRow& r, std::size_t c) { return r.neighbours[c].port; });
  column("errors", RS_PORTS, std::uint8_t{},
         [](const TopologyRow& r, std::size_t c) { return r.neighbours[c].errors; });
  return dict;
}

nb::list units_list(SnapshotTable<UnitRow>& table) {
  nb::list list;
  for (const UnitRow& unit : table.read()) {
    if (unit.heard_ns == 0) continue;
    nb::dict dict;
    dict["group"] = unit.group;
    dict["unit"] = unit.unit;
    dict["session"] = unit.session;
    dict["version"] = unit.version;
    dict["heard_ns"] = unit.heard_ns;
    dict["clock_offset_ns"] = unit.clock_offset_ns;
    dict["datagrams"] = unit.datagrams;
    dict["datagrams_lost"] = unit.datagrams_lost;
    dict["frames_dropped"] = unit.frames_dropped;
    nb::list ports;
    for (std::size_t port = 1; port < unit.ports.size(); ++port) {
      const UnitPortRow& row = unit.ports[port];
      if (row.heard_ns == 0) continue;
      nb::dict of_port;
      of_port["port"] = port;
      of_port["cell"] = row.cell;
      of_port["cell_port"] = row.cell_port;
      of_port["size"] = row.size;
      of_port["height"] = row.height;
      of_port["heard_ns"] = row.heard_ns;
      ports.append(of_port);
    }
    dict["ports"] = ports;
    list.append(dict);
  }
  return list;
}

nb::dict torques_dict(SnapshotTable<LimbTorque>& table) {
  std::vector<LimbTorque> rows;
  for (const LimbTorque& row : table.read())
    if (row.heard_ns != 0) rows.push_back(row);
  nb::dict dict;
  const auto column = [&]<class Value>(const char* name, std::size_t columns, Value, const auto& value) {
    dict[name] = filled<Value>(rows.size(), columns, [&](std::size_t i, std::size_t c) { return value(rows[i], c); });
  };
  column("group", 1, std::uint16_t{}, [](const LimbTorque& r, std::size_t) { return r.group; });
  column("limb", 1, std::uint8_t{}, [](const LimbTorque& r, std::size_t) { return r.limb; });
  column("epoch", 1, std::int64_t{}, [](const LimbTorque& r, std::size_t) { return r.epoch; });
  column("joint", torque_joints_max, std::int32_t{}, [](const LimbTorque& r, std::size_t c) { return r.joint[c]; });
  column("cells", 4, std::uint32_t{}, [](const LimbTorque& r, std::size_t c) { return r.cells[c]; });
  column("active", 1, std::uint32_t{}, [](const LimbTorque& r, std::size_t) { return r.active; });
  column("age", 1, std::uint8_t{}, [](const LimbTorque& r, std::size_t) { return r.age; });
  column("saturated", 1, bool{}, [](const LimbTorque& r, std::size_t) { return r.saturated; });
  column("whole", 1, bool{}, [](const LimbTorque& r, std::size_t) { return r.whole; });
  column("heard_ns", 1, std::int64_t{}, [](const LimbTorque& r, std::size_t) { return r.heard_ns; });
  column("epoch_ns", 1, std::int64_t{}, [](const LimbTorque& r, std::size_t) { return r.epoch_ns; });
  column("vectors", 1, std::uint64_t{}, [](const LimbTorque& r, std::size_t) { return r.vectors; });
  column("partial", 1, std::uint64_t{}, [](const LimbTorque& r, std::size_t) { return r.partial; });
  return dict;
}

nb::list replies_list(Driver& driver) {
  nb::list list;
  while (const std::optional<Reply> reply = driver.reply()) {
    nb::dict dict;
    dict["key"] = CellKey{reply->group} << 16 | reply->source;
    dict["operation"] = operation_name(reply->operation);
    dict["status"] = reply_status_name(reply->status);
    dict["ticket"] = reply->ticket;
    dict["index"] = reply->index;
    dict["of"] = operation_name(reply->value_high);
    dict["value"] = reply->value;
    dict["heard_ns"] = reply->heard_ns;
    dict["version"] = reply->version;
    list.append(dict);
  }
  return list;
}

}  // namespace robotskin::bindings
