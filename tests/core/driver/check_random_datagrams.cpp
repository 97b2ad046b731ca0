// SPDX-License-Identifier: Apache-2.0
// Random and mutated datagrams change nothing but counters, unless their tag is right; nothing of them is out of
// bounds. Usage: check_random_datagrams SEED COUNT. Half of them meet a driver with a key, half one without.
#include <algorithm>
#include <deque>

#include "check.hpp"
#include "driver/driver.hpp"
#include "skin/skin_reader.hpp"
#include "traffic/traffic.hpp"

using namespace robotskin;
using driver::Verdict;

namespace {

constexpr std::size_t cells = 400;
constexpr std::int64_t ms = 1'000'000;
using Bytes = std::vector<std::uint8_t>;

void sign(Bytes& datagram, const driver::KeyedHash& hash) {
  if (datagram.size() < RS_DATAGRAM_TAG_BYTES) return;
  const std::size_t covered = datagram.size() - RS_DATAGRAM_TAG_BYTES;
  const driver::Tag tag = hash.tag({datagram.data(), covered});
  std::copy(tag.begin(), tag.end(), datagram.begin() + static_cast<std::ptrdiff_t>(covered));
}

// Changes bits, bytes, length, header fields or records.
void mutate(Bytes& datagram, Random& random) {
  for (std::uint64_t changes = 1 + random.below(4); changes > 0; --changes) {
    if (datagram.empty()) datagram.push_back(0);
    const std::size_t at = random.below(datagram.size());
    switch (random.below(7)) {
      case 0:
        datagram[at] ^= static_cast<std::uint8_t>(1U << random.below(8));
        break;
      case 1:
        datagram[at] = static_cast<std::uint8_t>(random.draw());
        break;
      case 2:
        datagram.resize(random.below(RS_DATAGRAM_BYTES_MAX + 60));
        break;
      case 3:
        datagram[random.below(std::min<std::size_t>(datagram.size(), RS_DATAGRAM_HEADER_BYTES))] =
            static_cast<std::uint8_t>(random.draw());
        break;
      case 4:  // another frame type
        if (datagram.size() > RS_DATAGRAM_HEADER_BYTES) {
          const std::size_t records = (datagram.size() - RS_DATAGRAM_HEADER_BYTES) / RS_DATAGRAM_RECORD_BYTES + 1;
          const std::size_t record = RS_DATAGRAM_HEADER_BYTES + random.below(records) * RS_DATAGRAM_RECORD_BYTES;
          if (record < datagram.size()) datagram[record] = static_cast<std::uint8_t>(random.draw());
        }
        break;
      case 5:
        datagram.insert(datagram.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(random.draw()));
        break;
      default: {  // a boundary value in a field of the header
        constexpr std::size_t fields[] = {6, 8, 12, 16, 20, 24, 26, 28, 32};
        const std::size_t field = fields[random.below(std::size(fields))];
        for (std::size_t i = field; i < field + 2 && i < datagram.size(); ++i) {
          datagram[i] = random.below(2) != 0 ? 0xFF : 0x00;
        }
      }
    }
  }
}

std::uint64_t verdicts(const driver::Statistics& statistics) {
  std::uint64_t sum = 0;
#define ROBOTSKIN_ADD(name, meaning) sum += statistics.name.get();
  ROBOTSKIN_DATAGRAM_VERDICTS(ROBOTSKIN_ADD)
#undef ROBOTSKIN_ADD
  return sum;
}

void throw_at_driver(bool keyed, std::uint64_t seed, std::uint64_t count) {
  Random random(seed);
  driver::Key key;
  for (std::uint8_t& byte : key) byte = static_cast<std::uint8_t>(random.draw());
  const driver::KeyedHash hash(key);
  lab::TrafficOptions traffic_options;
  traffic_options.cells = cells;
  traffic_options.seed = seed;
  if (keyed) traffic_options.key = key;
  lab::Traffic traffic(traffic_options);
  driver::Options options;
  options.keys = traffic.keys();
  if (keyed) options.key = key;
  options.session_seed = seed;
  options.spare_cells = 8;
  options.spare_groups = 2;
  driver::Driver driver(options);
  skin::SkinModel model;
  model.key = traffic.keys();
  skin::SkinReader reader(driver.samples(), model);
  skin::SkinState state;
  state.resize(cells);

  std::deque<Bytes> valid;
  std::int64_t now_ns = 1'000'000 * ms;
  std::uint64_t handled = 0;
  for (std::uint64_t thrown = 0; thrown < count;) {
    now_ns += ms;
    driver.downlink(now_ns,
                    [&](const driver::Recipient&, std::span<const std::uint8_t> bytes) { traffic.hear(bytes); });
    traffic.step(static_cast<std::uint64_t>(now_ns), [&](std::span<const std::uint8_t> bytes) {
      driver.handle(bytes, now_ns);
      ++handled;
      valid.emplace_back(bytes.begin(), bytes.end());
      if (valid.size() > 64) valid.pop_front();
    });
    for (unsigned i = 0; i < 200 && thrown < count; ++i, ++thrown) {
      Bytes datagram;
      const bool from_valid = !valid.empty() && random.below(8) != 0;
      if (from_valid) {
        datagram = valid[random.below(valid.size())];
      } else {
        datagram.resize(random.below(RS_DATAGRAM_BYTES_MAX + 60));
        for (std::uint8_t& byte : datagram) byte = static_cast<std::uint8_t>(random.draw());
      }
      const Bytes before = datagram;
      mutate(datagram, random);
      // One in four is signed after the change, as only a broken section unit could do.
      const bool resigned = keyed && random.below(4) == 0;
      if (resigned) sign(datagram, hash);
      // An exact buffer, so that a read beyond the end is seen.
      const Bytes exact(datagram.begin(), datagram.end());
      const Verdict verdict = driver.handle(exact, now_ns);
      ++handled;
      const bool changed = datagram != before;
      if (keyed && !resigned && changed) CHECK(verdict != Verdict::accepted);
    }
    driver.publish(now_ns);
    reader.read(now_ns, state);
    while (driver.reply()) {
    }
    for (std::size_t cell = 0; cell < cells; ++cell) {
      CHECK(state.stamp_ns[cell] <= now_ns);
      CHECK(static_cast<unsigned>(state.health[cell]) <= static_cast<unsigned>(skin::Health::never_seen));
      CHECK(state.normal_force[cell][0] >= 0 && state.normal_force[cell][0] <= 10);
      CHECK(state.proximity[cell] >= 0 && state.proximity[cell] < 1);
      CHECK(state.distance[cell] >= 0);
    }
  }
  CHECK(verdicts(driver.statistics()) == handled);
  std::printf("%s: %llu datagrams, %llu accepted, %llu of them frames\n", keyed ? "keyed" : "open",
              static_cast<unsigned long long>(handled),
              static_cast<unsigned long long>(driver.statistics().accepted.get()),
              static_cast<unsigned long long>(driver.statistics().frames.get()));
}

}  // namespace

int main(int count, char** values) {
  const std::uint64_t seed = argument(count, values, 1, 1), datagrams = argument(count, values, 2, 1'000'000);
  throw_at_driver(true, seed, datagrams / 2);
  throw_at_driver(false, seed + 1, datagrams - datagrams / 2);
}
