// SPDX-License-Identifier: Apache-2.0
// The events to come, in order of time; equal times in the order they were put in.
//
// A timing wheel: 32768 buckets of 64 ns, each a list, and a bitmap that finds the next bucket with something in it.
// A list has the latest comer first, and is put in order when its turn comes: so a push costs the same however many
// events are waiting. What lies further ahead than the wheel's 2.1 ms waits in a 4-ary heap. Nothing is allocated once
// as many events have been waiting as ever will.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace robotskin::world {

struct Event {
  std::int64_t time_ns;
  std::uint32_t what;  // the owner's business
};

class EventQueue {
 public:
  void reserve(std::size_t events) { nodes_.reserve(events); }
  std::size_t size() const { return near_ + far_.size(); }

  // `time_ns` must not lie before the last event taken.
  void push(std::int64_t time_ns, std::uint32_t what) {
    if (bucket_of(time_ns) >= base_ + buckets)
      push_far({time_ns, what, next_order_++});
    else
      push_near(time_ns, what);
  }

  // What the next event is about, if it comes within the wheel's turn: to fetch ahead what it will need.
  std::uint32_t next_what(std::uint32_t otherwise) const {
    return near_ == 0 ? otherwise : nodes_[wheel_->head[slot(next_bucket())]].what;
  }

  // Takes the first event if it lies before `end_ns`.
  bool pop_before(std::int64_t end_ns, Event& event) {
    if (near_ == 0) {
      if (far_.empty() || far_.front().time_ns >= end_ns) return false;
      move_to(bucket_of(far_.front().time_ns));
    }
    const std::int64_t bucket = next_bucket();
    std::int32_t& head = wheel_->head[slot(bucket)];
    if (nodes_[head].next != none && bucket != base_) {
      // Not before its turn has come for certain: earlier events may still be pushed.
      if (earliest(head) >= end_ns) return false;
      put_in_order(head);
    }
    Node& node = nodes_[head];
    if (node.time_ns >= end_ns) return false;
    event = {node.time_ns, node.what};
    const std::int32_t taken = head;
    head = node.next;
    if (head == none) wheel_->full[slot(bucket) / 64] &= ~(std::uint64_t{1} << (slot(bucket) % 64));
    node.next = free_;
    free_ = taken;
    --near_;
    if (bucket != base_) move_to(bucket);
    return true;
  }

 private:
  static constexpr std::int64_t buckets = 32768;
  static constexpr int bucket_shift = 6;  // 64 ns
  static constexpr std::int32_t none = -1;
  static constexpr std::size_t few = 8;  // that are put in order one by one

  struct Node {
    std::int64_t time_ns;
    std::uint32_t what;
    std::int32_t next;
  };
  struct Far {
    std::int64_t time_ns;
    std::uint32_t what;
    std::uint32_t order;  // of insertion; wraps, which matters only between events of equal time
  };
  struct Turn {
    std::int64_t time_ns;
    std::int32_t comers_after;  // in its list
    std::int32_t index;
  };
  struct Wheel {
    std::array<std::int32_t, buckets> head;
    std::array<std::uint64_t, buckets / 64> full;
  };

  static std::int64_t bucket_of(std::int64_t time_ns) { return time_ns >> bucket_shift; }
  static std::size_t slot(std::int64_t bucket) { return static_cast<std::size_t>(bucket & (buckets - 1)); }

  static std::unique_ptr<Wheel> empty_wheel() {
    auto wheel = std::make_unique<Wheel>();
    wheel->head.fill(none);
    wheel->full.fill(0);
    return wheel;
  }

  // The first bucket from `base_` on that holds something; there is one.
  std::int64_t next_bucket() const {
    const std::size_t start = slot(base_);
    std::size_t word = start / 64;
    std::uint64_t bits = wheel_->full[word] & (~std::uint64_t{0} << (start % 64));
    while (bits == 0) bits = wheel_->full[word = (word + 1) % wheel_->full.size()];
    const std::size_t found = 64 * word + static_cast<std::size_t>(std::countr_zero(bits));
    return base_ + static_cast<std::int64_t>((found - start) & (buckets - 1));
  }

  void move_to(std::int64_t bucket) {
    base_ = bucket;
    while (!far_.empty() && bucket_of(far_.front().time_ns) < base_ + buckets) {
      const Far event = pop_far();
      push_near(event.time_ns, event.what);
    }
  }

  void push_near(std::int64_t time_ns, std::uint32_t what) {
    std::int32_t index = free_;
    if (index == none) {
      index = static_cast<std::int32_t>(nodes_.size());
      nodes_.push_back({});
    } else {
      free_ = nodes_[index].next;
    }
    const std::size_t at = slot(bucket_of(time_ns));
    std::int32_t* link = &wheel_->head[at];
    if (bucket_of(time_ns) == base_)
      while (*link != none && nodes_[*link].time_ns <= time_ns) link = &nodes_[*link].next;
    nodes_[index] = {time_ns, what, *link};
    *link = index;
    wheel_->full[at / 64] |= std::uint64_t{1} << (at % 64);
    ++near_;
  }

  std::int64_t earliest(std::int32_t at) const {
    std::int64_t time_ns = nodes_[at].time_ns;
    while ((at = nodes_[at].next) != none) time_ns = std::min(time_ns, nodes_[at].time_ns);
    return time_ns;
  }

  // Equal times in the order they came: in a list that has the latest comer first.
  void put_in_order(std::int32_t& head) {
    std::size_t count = 0;
    for (std::int32_t at = head; at != none && count <= few; at = nodes_[at].next) ++count;
    head = count <= few ? inserted_one_by_one(head) : sorted(head);
  }

  std::int32_t inserted_one_by_one(std::int32_t rest) {
    std::int32_t head = none;
    while (rest != none) {
      Node& node = nodes_[rest];
      std::int32_t* link = &head;
      while (*link != none && nodes_[*link].time_ns < node.time_ns) link = &nodes_[*link].next;
      const std::int32_t next = node.next;
      node.next = *link;
      *link = rest;
      rest = next;
    }
    return head;
  }

  std::int32_t sorted(std::int32_t rest) {
    turn_.clear();
    for (; rest != none; rest = nodes_[rest].next)
      turn_.push_back({nodes_[rest].time_ns, static_cast<std::int32_t>(turn_.size()), rest});
    std::ranges::sort(turn_, [](const Turn& a, const Turn& b) {
      return a.time_ns != b.time_ns ? a.time_ns > b.time_ns : a.comers_after < b.comers_after;
    });
    std::int32_t head = none;
    for (const Turn& turn : turn_) {
      nodes_[turn.index].next = head;
      head = turn.index;
    }
    return head;
  }

  static bool before(const Far& a, const Far& b) {
    if (a.time_ns != b.time_ns) return a.time_ns < b.time_ns;
    return static_cast<std::int32_t>(a.order - b.order) < 0;
  }

  void push_far(const Far& event) {
    std::size_t hole = far_.size();
    far_.push_back(event);
    for (; hole > 0 && before(event, far_[(hole - 1) / 4]); hole = (hole - 1) / 4) far_[hole] = far_[(hole - 1) / 4];
    far_[hole] = event;
  }

  Far pop_far() {
    const Far top = far_.front(), moved = far_.back();
    far_.pop_back();
    std::size_t hole = 0;
    for (;;) {
      std::size_t best = 4 * hole + 1;
      if (best >= far_.size()) break;
      for (std::size_t other = best + 1; other < 4 * hole + 5 && other < far_.size(); ++other)
        if (before(far_[other], far_[best])) best = other;
      if (!before(far_[best], moved)) break;
      far_[hole] = far_[best];
      hole = best;
    }
    if (!far_.empty()) far_[hole] = moved;
    return top;
  }

  std::unique_ptr<Wheel> wheel_ = empty_wheel();
  std::vector<Node> nodes_;
  std::vector<Far> far_;
  std::vector<Turn> turn_;
  std::int64_t base_ = 0;  // bucket of the last event taken, whose list is in order
  std::size_t near_ = 0;
  std::int32_t free_ = none;
  std::uint32_t next_order_ = 0;
};

}  // namespace robotskin::world
