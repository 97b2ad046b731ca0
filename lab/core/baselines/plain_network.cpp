// SPDX-License-Identifier: Apache-2.0
#include "baselines/plain_network.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "world/network/event_queue.hpp"
#include "world/random.hpp"

namespace robotskin::lab {
namespace {

using world::Event;
using world::EventQueue;
using world::random_unit;
using world::stream_key;

constexpr std::int64_t frame_ns = 50000;
constexpr std::uint32_t make_event = 0x80000000U;  // else: a node's frame has been sent
constexpr std::uint32_t none = 0xFFFFFFFFU;

struct Frame {
  std::int64_t made_ns;
  std::uint32_t after;  // in the same queue
};

struct Node {
  std::uint32_t first = none, last = none;  // frames that wait; the first one is on the wire
  std::uint32_t waiting = 0;
  std::int32_t next = -1;
};

class PlainNetwork {
 public:
  PlainNetwork(const std::vector<std::int32_t>& next, std::int64_t period_ns, std::uint64_t seed)
      : nodes_(next.size()), period_ns_(period_ns) {
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (next[i] < -1 || next[i] >= static_cast<std::int32_t>(next.size()))
        throw std::invalid_argument("plain network: node " + std::to_string(i) + " sends to " +
                                    std::to_string(next[i]) + ": there are nodes 0 to " +
                                    std::to_string(next.size() - 1) + ", and -1");
      nodes_[i].next = next[i];
      const double phase = random_unit(stream_key(seed, 0, i), 0);
      events_.push(static_cast<std::int64_t>(phase * static_cast<double>(period_ns)),
                   make_event | static_cast<std::uint32_t>(i));
    }
  }

  PlainCounts run(std::int64_t end_ns) {
    for (Event event{}; events_.pop_before(end_ns, event);) {
      now_ns_ = event.time_ns;
      if ((event.what & make_event) != 0) {
        make(event.what & ~make_event);
      } else {
        finish(event.what);
      }
    }
    if (counts_.arrived > 0)
      counts_.delay_mean_us = 1e-3 * static_cast<double>(delay_ns_) / static_cast<double>(counts_.arrived);
    return counts_;
  }

 private:
  void make(std::uint32_t node) {
    ++counts_.made;
    std::uint32_t frame = free_;
    if (frame == none) {
      frame = static_cast<std::uint32_t>(frames_.size());
      frames_.push_back({});
    } else {
      free_ = frames_[frame].after;
    }
    frames_[frame].made_ns = now_ns_;
    enqueue(node, frame);
    events_.push(now_ns_ + period_ns_, make_event | node);
  }

  void enqueue(std::uint32_t index, std::uint32_t frame) {
    Node& node = nodes_[index];
    frames_[frame].after = none;
    if (node.first == none) {
      node.first = frame;
      events_.push(now_ns_ + frame_ns, index);
    } else {
      frames_[node.last].after = frame;
    }
    node.last = frame;
    counts_.queue_peak = std::max(counts_.queue_peak, ++node.waiting);
  }

  void finish(std::uint32_t index) {
    Node& node = nodes_[index];
    const std::uint32_t frame = node.first;
    node.first = frames_[frame].after;
    --node.waiting;
    ++counts_.hops;
    if (node.first != none) events_.push(now_ns_ + frame_ns, index);
    if (node.next >= 0) {
      enqueue(static_cast<std::uint32_t>(node.next), frame);
    } else {
      ++counts_.arrived;
      delay_ns_ += now_ns_ - frames_[frame].made_ns;
      frames_[frame].after = free_;
      free_ = frame;
    }
  }

  std::vector<Node> nodes_;
  std::vector<Frame> frames_;
  std::uint32_t free_ = none;
  EventQueue events_;
  PlainCounts counts_;
  std::int64_t period_ns_, now_ns_ = 0, delay_ns_ = 0;
};

}  // namespace

PlainCounts run_plain_network(const std::vector<std::int32_t>& next, std::int64_t period_ns, std::int64_t duration_ns,
                              std::uint64_t seed) {
  return PlainNetwork(next, period_ns, seed).run(duration_ns);
}

}  // namespace robotskin::lab
