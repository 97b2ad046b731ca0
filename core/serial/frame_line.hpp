// SPDX-License-Identifier: Apache-2.0
// Frames over a line: out as they are, in by the receiver that cells have, and what is counted of both.
#pragma once

#include <array>
#include <memory>

#include "robotskin/receiver.h"
#include "serial/line.hpp"
#include "serial/unit_side.hpp"

namespace robotskin::serial {

struct LineCounts {
  std::uint64_t frames_in = 0, frames_out = 0;
  std::uint64_t damaged = 0;  // came with a wrong checksum, or cut
  std::uint64_t unsent = 0;   // found no room, or no line
  std::uint64_t pulled = 0;   // times that the line was gone
};

class FrameLine {
 public:
  explicit FrameLine(std::unique_ptr<Line> line) : line_(std::move(line)) {}

  void send(FrameBytes frame) { ++(line_->write(frame) ? counts_.frames_out : counts_.unsent); }

  // Calls take(FrameBytes) for each frame that has come.
  template <typename Take>
  void receive(std::int64_t now_ns, Take&& take) {
    line_->tend(now_ns);
    std::array<std::uint8_t, 4096> bytes;
    while (const std::size_t count = line_->read(bytes)) {
      // An adapter cuts frames where its packets end, so silence says little before some milliseconds are over.
      if (now_ns - heard_ns_ > idle_ns && rs_receiver_idle(&receiver_)) ++counts_.damaged;
      heard_ns_ = now_ns;
      for (std::size_t i = 0; i < count; ++i) {
        std::array<std::uint8_t, RS_FRAME_BYTES> frame;
        const rs_received received = rs_receiver_byte(&receiver_, bytes[i], frame.data());
        if (received == RS_RECEIVED_DAMAGED) ++counts_.damaged;
        if (received != RS_RECEIVED_FRAME) continue;
        ++counts_.frames_in;
        take(FrameBytes(frame));
      }
      if (count < bytes.size()) break;
    }
  }

  int descriptor() const { return line_->descriptor(); }
  LineCounts counts() const {
    LineCounts found = counts_;
    found.pulled = line_->pulled();
    return found;
  }

 private:
  static constexpr std::int64_t idle_ns = 5'000'000;

  std::unique_ptr<Line> line_;
  rs_receiver receiver_{};
  std::int64_t heard_ns_ = 0;
  LineCounts counts_;
};

}  // namespace robotskin::serial
