// SPDX-License-Identifier: Apache-2.0
// The window of sequence numbers agrees with a plain set, for any mixture of order, repetition and jumps, over the
// wrap. Usage: check_sequence_window SEED TRIALS
#include <algorithm>
#include <set>

#include "check.hpp"
#include "driver/sequence_window.hpp"

using namespace robotskin;
using driver::SequenceWindow;

int main(int count, char** values) {
  Random random(argument(count, values, 1, 1));
  const std::uint64_t trials = argument(count, values, 2, 200);
  for (std::uint64_t trial = 0; trial < trials; ++trial) {
    SequenceWindow window;
    std::set<std::int64_t> seen;  // unwrapped
    const std::uint32_t start = trial % 2 == 0 ? 0xFFFFFF00U : static_cast<std::uint32_t>(random.draw());
    std::int64_t newest = 0, first = 0;
    for (unsigned i = 0; i < 2000; ++i) {
      std::int64_t next = newest + static_cast<std::int64_t>(random.below(40)) - 20;
      if (random.below(50) == 0) next = newest + static_cast<std::int64_t>(random.below(4000)) - 2000;
      const SequenceWindow::Verdict verdict = window.take(start + static_cast<std::uint32_t>(next));
      if (seen.empty()) newest = first = next;
      if (next <= newest - static_cast<std::int64_t>(SequenceWindow::width)) {
        CHECK(verdict == SequenceWindow::Verdict::too_old);
        continue;
      }
      CHECK((verdict == SequenceWindow::Verdict::seen) == seen.contains(next));
      CHECK(verdict != SequenceWindow::Verdict::too_old);
      seen.insert(next);
      newest = std::max(newest, next);
      if (newest - first < static_cast<std::int64_t>(SequenceWindow::width)) first = std::min(first, next);
      if (*seen.begin() >= first) {
        CHECK(window.missing() == static_cast<std::uint64_t>(newest - first + 1) - seen.size());
      }
    }
  }
}
