// SPDX-License-Identifier: Apache-2.0
#include "serial/commissioner.hpp"

#include <poll.h>

#include <array>
#include <memory>
#include <vector>

#include "driver/clock.hpp"
#include "robotskin/commissioning.h"
#include "serial/frame_line.hpp"
#include "serial/serial_error.hpp"
#include "serial/serial_line.hpp"

namespace robotskin::serial {
namespace {

constexpr std::int64_t ask_ns = 50'000'000;
using Frame = std::array<std::uint8_t, RS_FRAME_BYTES>;

// The one line, and what was heard on it.
class Conversation {
 public:
  Conversation(const std::string& path, std::chrono::milliseconds within)
      : path_(path), line_(std::make_unique<SerialLine>(path)), within_ns_(std::chrono::nanoseconds(within).count()) {}

  // Says `frames` again and again until the cell answers with one of two steps; none in time: nothing.
  std::optional<rs_key> ask(const std::vector<Frame>& frames, std::uint32_t step, std::uint32_t other) {
    const std::int64_t ends_ns = driver::monotonic_ns() + within_ns_;
    std::optional<rs_key> answer;
    for (std::int64_t next_ns = 0; !answer;) {
      const std::int64_t now_ns = driver::monotonic_ns();
      if (now_ns >= ends_ns) return std::nullopt;
      if (now_ns >= next_ns) {
        for (const Frame& frame : frames) line_.send(frame);
        next_ns = now_ns + ask_ns;
      }
      pollfd wanted{line_.descriptor(), POLLIN, 0};
      const timespec pause{0, ask_ns / 10};
      ppoll(&wanted, 1, &pause, nullptr);
      line_.receive(driver::monotonic_ns(), [&](FrameBytes frame) {
        others_ += rs_frame_type_of(frame.data()) != RS_TYPE_key;
        if (rs_frame_type_of(frame.data()) != RS_TYPE_key) return;
        rs_key said;
        rs_key_unpack(&said, frame.data());
        if (said.step == step || said.step == other) answer = said;
      });
    }
    return answer;
  }

  [[noreturn]] void fail(const std::string& why) const { throw SerialError("serial line " + path_ + ": " + why); }

  [[noreturn]] void fail_without_cell() const {
    if (others_ > 0)
      fail(
          "found a cell that has keys already, or a section unit; a cell takes keys once. Clear the cell's keys at its "
          "board first (docs/build_a_cell.md)");
    if (line_.counts().damaged > 0) fail("found bytes that are no frames, expected a cell at 4 Mb/s");
    fail("found no cell; is it on, and its line out to in and in to out?");
  }

 private:
  std::string path_;
  FrameLine line_;
  std::int64_t within_ns_;
  std::uint64_t others_ = 0;
};

Frame frame_of_words(std::uint32_t step, std::uint32_t first = 0, std::uint32_t second = 0) {
  Frame frame;
  rs_key_frame_of_words(frame.data(), step, first, second);
  return frame;
}

}  // namespace

std::uint32_t commission(const std::string& path, const CellKey& secret, std::optional<std::uint32_t> expected,
                         std::chrono::milliseconds within) {
  Conversation line(path, within);
  const std::optional<rs_key> cell = line.ask({frame_of_words(RS_KEY_ask)}, RS_KEY_factory, RS_KEY_refused);
  if (!cell) line.fail_without_cell();
  const std::uint32_t uid = cell->word_1;
  const std::string name = "cell " + std::to_string(uid);
  if (expected && uid != *expected) line.fail("found " + name + ", expected cell " + std::to_string(*expected));
  if (cell->step == RS_KEY_refused) line.fail("found " + name + ", which has been given keys a moment ago");
  if (cell->word_2 != RS_FIRMWARE_VERSION)
    line.fail(name + ": found firmware of version " + std::to_string(cell->word_2) + ", expected " +
              std::to_string(RS_FIRMWARE_VERSION) + "; flash it anew (robotskin chip build)");

  std::array<std::uint8_t, RS_CELL_KEYS_BYTES> keys;
  rs_cell_keys(secret.data(), uid, keys.data());
  Frame group, own;
  rs_key_frame_of_key(group.data(), RS_KEY_group, keys.data());
  rs_key_frame_of_key(own.data(), RS_KEY_own, keys.data() + RS_CELL_KEY_BYTES);
  const Frame keep = frame_of_words(RS_KEY_keep, uid, rs_key_check(keys.data(), uid, RS_KEY_keep));
  const std::optional<rs_key> kept = line.ask({group, own, keep}, RS_KEY_kept, RS_KEY_refused);
  if (!kept) line.fail(name + " did not say that it has kept its keys; try again");
  if (kept->step == RS_KEY_refused || kept->word_1 != uid ||
      !rs_tags_equal(kept->word_2, rs_key_check(keys.data(), uid, RS_KEY_kept)))
    line.fail(name + " refused the keys; try again");
  return uid;
}

}  // namespace robotskin::serial
