// SPDX-License-Identifier: Apache-2.0
// No torn row is ever seen, versions never go back, and a publication shows everything changed before it.
// Usage: check_snapshot_table SEED SNAPSHOTS. One thread writes, one reads, until it has seen so many publications.
#include <array>
#include <atomic>
#include <thread>

#include "check.hpp"
#include "driver/snapshot_table.hpp"

using namespace robotskin;

namespace {

struct Row {
  std::array<std::uint64_t, 8> word{};  // all equal, or the row is torn
};

}  // namespace

int main(int count, char** values) {
  const std::uint64_t seed = argument(count, values, 1, 1), wanted = argument(count, values, 2, 20'000);
  constexpr std::size_t rows = 64;
  driver::SnapshotTable<Row> table(rows);
  std::atomic<bool> enough{false};
  std::uint64_t publications = 0;

  std::thread writer([&] {
    Random random(seed), pace(seed + 1);
    for (std::uint64_t version = 1; !enough; publications = version++) {
      // Row 0 changes in every publication, so it tells which one is read.
      table.change(0).word.fill(version);
      for (std::uint64_t changes = random.below(8); changes > 0; --changes) {
        table.change(random.below(rows)).word.fill(version);
      }
      table.publish(static_cast<std::int64_t>(version));
      // Where there is but one processor, each gives the other its turn.
      if (pace.below(8) == 0) std::this_thread::yield();
    }
  });

  std::array<std::uint64_t, rows> seen{};
  std::uint64_t snapshots = 0;
  const auto look = [&] {
    const std::span<const Row> read = table.read();
    const std::uint64_t published = static_cast<std::uint64_t>(table.published_ns());
    CHECK(read[0].word[0] == published);
    snapshots += published != seen[0];
    for (std::size_t i = 0; i < rows; ++i) {
      for (const std::uint64_t word : read[i].word) CHECK(word == read[i].word[0]);
      CHECK(read[i].word[0] >= seen[i]);
      CHECK(read[i].word[0] <= published);
      seen[i] = read[i].word[0];
    }
  };
  for (std::uint64_t before = 0; snapshots < wanted; before = snapshots) {
    look();
    if (snapshots == before) std::this_thread::yield();
  }
  enough = true;
  writer.join();
  look();

  // At the end all rows are those of the writer: replay its draws.
  Random random(seed);
  std::array<std::uint64_t, rows> expected{};
  for (std::uint64_t version = 1; version <= publications; ++version) {
    expected[0] = version;
    for (std::uint64_t changes = random.below(8); changes > 0; --changes) expected[random.below(rows)] = version;
  }
  CHECK(seen == expected);
  std::printf("%llu publications, %llu different snapshots seen\n", static_cast<unsigned long long>(publications),
              static_cast<unsigned long long>(snapshots));
}
