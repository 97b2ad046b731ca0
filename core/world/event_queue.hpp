// The events to come, in order of time; equal times in the order they were put in. A 4-ary heap over plain structs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace robotskin::world {

struct Event {
  std::int64_t time_ns;
  std::uint32_t order;  // of insertion; wraps, which matters only between events of equal time
  std::uint32_t what;   // the owner's business
};

class EventQueue {
 public:
  void reserve(std::size_t events) { heap_.reserve(events); }
  bool empty() const { return heap_.empty(); }
  std::size_t size() const { return heap_.size(); }
  const Event& first() const { return heap_.front(); }

  void push(std::int64_t time_ns, std::uint32_t what) {
    const Event event{time_ns, next_order_++, what};
    std::size_t hole = heap_.size();
    heap_.push_back(event);
    while (hole > 0) {
      const std::size_t parent = (hole - 1) / 4;
      if (!before(event, heap_[parent])) break;
      heap_[hole] = heap_[parent];
      hole = parent;
    }
    heap_[hole] = event;
  }

  Event pop() {
    const Event top = heap_.front(), moved = heap_.back();
    heap_.pop_back();
    const std::size_t size = heap_.size();
    if (size == 0) return top;
    std::size_t hole = 0;
    for (;;) {
      const std::size_t child = 4 * hole + 1;
      if (child >= size) break;
      const std::size_t end = child + 4 < size ? child + 4 : size;
      std::size_t best = child;
      for (std::size_t other = child + 1; other < end; ++other)
        if (before(heap_[other], heap_[best])) best = other;
      if (!before(heap_[best], moved)) break;
      heap_[hole] = heap_[best];
      hole = best;
    }
    heap_[hole] = moved;
    return top;
  }

 private:
  static bool before(const Event& a, const Event& b) {
    if (a.time_ns != b.time_ns) return a.time_ns < b.time_ns;
    return static_cast<std::int32_t>(a.order - b.order) < 0;
  }

  std::vector<Event> heap_;
  std::uint32_t next_order_ = 0;
};

}  // namespace robotskin::world
