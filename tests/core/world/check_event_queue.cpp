// SPDX-License-Identifier: Apache-2.0
// Events come in order of time, equal times in the order they were put in, however many share a bucket: as from a heap.
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "check.hpp"
#include "world/network/event_queue.hpp"

namespace {

using robotskin::Random;

void check_like_a_heap(Random& random, std::size_t waiting) {
  using Entry = std::pair<std::int64_t, std::uint32_t>;  // time, number in order of coming
  robotskin::world::EventQueue queue;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap;
  std::uint32_t number = 0;
  std::int64_t now_ns = 0;
  const auto push = [&](std::int64_t time_ns) {
    queue.push(time_ns, number);
    heap.emplace(time_ns, number++);
  };
  for (std::size_t i = 0; i < waiting; ++i) push(static_cast<std::int64_t>(random.below(5000)));
  for (int turn = 0; turn < 20000 && !heap.empty(); ++turn) {
    const std::int64_t end_ns = now_ns + static_cast<std::int64_t>(random.below(200));
    robotskin::world::Event event{};
    if (!queue.pop_before(end_ns, event)) {
      CHECK(heap.top().first >= end_ns);
      now_ns = end_ns;
    } else {
      CHECK(heap.top() == Entry(event.time_ns, event.what));
      heap.pop();
      now_ns = event.time_ns;
    }
    CHECK(queue.size() == heap.size());
    const auto later = [&](std::uint64_t least_ns, std::uint64_t range_ns) {
      push(now_ns + static_cast<std::int64_t>(least_ns + random.below(range_ns)));
    };
    switch (random.below(8)) {
      case 0:
        later(0, 1);
        break;
      case 1:
        later(0, 70);
        break;
      case 2:
        later(1000000, 4000000);
        break;
      case 3:
        break;
      default:
        later(50000, 100);
        break;
    }
  }
}

}  // namespace

int main(int count, char** values) {
  Random random(robotskin::argument(count, values, 1, 1));
  for (const std::size_t waiting : {1, 20, 500, 20000}) check_like_a_heap(random, waiting);
}
