// SPDX-License-Identifier: Apache-2.0
// A network that is run in lanes, by any number of threads, is the network that is run in one piece: the same cells,
// counts and datagrams. With a wire between two lanes it goes on as one of both.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "check.hpp"
#include "world/network/network.hpp"

namespace {

using namespace robotskin;

constexpr std::int32_t columns = 4, rows = 5, sheet_cells = columns * rows;
constexpr std::uint16_t groups[] = {7, 3, 3, 9};  // of four sheets; two section units are peers
constexpr std::int64_t ms = 1'000'000;

// Sheets of cells, each at a section unit of its own.
world::Wiring wiring() {
  world::Wiring found;
  for (std::int32_t sheet = 0; sheet < 4; ++sheet) {
    const std::int32_t first = sheet * sheet_cells;
    for (std::int32_t cell = 0; cell < sheet_cells; ++cell) {
      std::array<world::CellEnd, 4> ends{};
      if (cell % columns + 1 < columns) ends[0] = {first + cell + 1, 3};
      if (cell + columns < sheet_cells) ends[1] = {first + cell + columns, 4};
      if (cell % columns > 0) ends[2] = {first + cell - 1, 1};
      if (cell >= columns) ends[3] = {first + cell - columns, 2};
      found.neighbours.push_back(ends);
      found.id.push_back(RS_ID_NONE);
    }
    world::UnitDescription unit{};
    unit.group = groups[sheet];
    unit.unit = static_cast<std::uint8_t>(sheet == 2 ? 1 : 0);
    unit.ports = {{first, 4}, {first + columns - 1, 4}};
    found.units.push_back(unit);
  }
  return found;
}

class Readings : public world::SampleSource {
 public:
  bool sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) override {
    for (std::int32_t& value : sample.value) value = static_cast<std::int32_t>((cell + time_ns / ms) % 200);
    return false;
  }
};

struct Sent {
  std::size_t unit;
  std::int64_t time_ns;
  std::vector<std::uint8_t> datagram;
  bool operator==(const Sent&) const = default;
};

class Host : public world::DatagramSink {
 public:
  void send(std::size_t unit, std::int64_t time_ns, std::span<const std::uint8_t> datagram) override {
    sent.push_back({unit, time_ns, {datagram.begin(), datagram.end()}});
  }
  std::vector<Sent> sent;
};

struct Run {
  std::uint64_t hash;
  world::NetworkCounts counts;
  std::vector<std::uint16_t> id;
  std::vector<std::uint8_t> hops;
  std::vector<Sent> sent;
  std::size_t lanes;
  bool formed;
};

Run run(std::uint64_t seed, std::size_t threads, world::Processor processor, std::string_view fault) {
  Readings readings;
  Host host;
  world::NetworkOptions options;
  options.seed = seed;
  options.unasked = true;
  options.line.lost_share = 1e-3;
  options.processor = processor;
  options.threads = threads;
  world::Network network(wiring(), options, readings, host);
  if (!fault.empty()) network.inject(world::parse_fault(fault));
  for (std::int64_t time_ms = 1; time_ms <= 400; ++time_ms) network.run_until(time_ms * ms);
  Run found{network.log_hash(), network.counts(), {}, {}, host.sent, network.lane_count(), network.formed()};
  for (std::size_t cell = 0; cell < network.cell_count(); ++cell) {
    found.id.push_back(network.cell(cell).id);
    found.hops.push_back(network.cell(cell).route.hops);
  }
  return found;
}

// Of each section unit by itself, in the order of their times.
std::vector<Sent> by_unit(std::vector<Sent> sent) {
  std::ranges::stable_sort(sent, {}, &Sent::unit);
  return sent;
}

bool same(const world::NetworkCounts& a, const world::NetworkCounts& b) {
  return a.frames_sent == b.frames_sent && a.frames_delivered == b.frames_delivered && a.frames_lost == b.frames_lost &&
         a.cell_steps == b.cell_steps && a.events == b.events && a.datagrams == b.datagrams &&
         a.datagram_bytes == b.datagram_bytes && a.records == b.records;
}

}  // namespace

// Usage: check_lanes SEED
int main(int count, char** values) {
  const std::uint64_t seed = argument(count, values, 1, 1);
  for (const world::Processor processor : {world::Processor::none, world::Processor::one_wait_state}) {
    const Run whole = run(seed, 0, processor, ""), one = run(seed, 1, processor, "");
    CHECK(whole.lanes == 1 && one.lanes == 3);
    CHECK(whole.formed && whole.counts.records > 1000);
    CHECK(same(one.counts, whole.counts));
    CHECK(one.id == whole.id && one.hops == whole.hops);
    CHECK(by_unit(one.sent) == by_unit(whole.sent));
    for (const std::size_t threads : {std::size_t{2}, std::size_t{4}}) {
      const Run several = run(seed, threads, processor, "");
      CHECK(several.hash == one.hash);
      CHECK(several.sent == one.sent);
    }
  }
  // The last cell of the first sheet and that of the last one are joined: two groups share a wire.
  constexpr std::string_view plug = "plug:cell=19,port=1,to=79,to_port=1@150ms";
  const Run whole = run(seed, 0, world::Processor::none, plug), joined = run(seed, 1, world::Processor::none, plug);
  CHECK(joined.formed && joined.hash == run(seed, 4, world::Processor::none, plug).hash);
  CHECK(same(joined.counts, whole.counts));
  CHECK(joined.id == whole.id && by_unit(joined.sent) == by_unit(whole.sent));
  return 0;
}
