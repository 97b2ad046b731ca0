// SPDX-License-Identifier: Apache-2.0
// A bounded queue of entries of any length from one thread to some readers: none waits, locks or allocates for another.
//
// It lies in memory that another process may share: a reader may be there, and outlive the one that writes.
// An entry is 16 bytes (little-endian: payload bytes u32, kind u16, flags u16, time in ns i64) and its payload,
// padded to a multiple of 8. Blocks of whole entries are what a recording holds, unchanged. What finds no room is
// dropped and counted, and the next entry that finds some is a `gap`, so that a reader knows where something is
// missing.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace robotskin::record {

// X(name, number, payload)
#define ROBOTSKIN_TAPE_ENTRIES(X)                                                                           \
  X(gap, 1, "u64: entries dropped before this one")                                                         \
  X(datagram, 2, "an accepted datagram, whole; time: its arrival on the host's clock")                      \
  X(publication, 3, "u64: number of the publication")                                                       \
  X(keyframe, 4, "all that the driver knows, as of the publication before it (keyframe.hpp)")               \
  X(sample, 5, "a decoded sample, never stored as such: 64 bytes as the driver holds it")                   \
  X(read, 6, "u64: number of the publication that the skin reader saw; time: of the read")                  \
  X(tare, 7, "i64: duration in ns of a tare that was asked for")                                            \
  X(reader_keyframe, 8, "all that the skin reader knows, as of the read after it")                          \
  X(joints, 9, "joint state: 3 n f64 position, velocity, effort; time: its stamp")                          \
  X(command, 10, "u64 mode, n f64 values; time: of the tick; mode 3: joints have their own")                \
  X(force_zero, 11, "3 n f32 newton: what the skin reader subtracts from each force from now on")           \
  X(felt, 12, "the skin state of a tick, of a skin without our driver (felt_state.hpp); time: of the tick") \
  X(nothing_felt, 13, "nothing: a tick in which such a skin had nothing new; time: of the tick")

enum class Entry : std::uint16_t {
#define ROBOTSKIN_ENTRY(name, number, payload) name = number,
  ROBOTSKIN_TAPE_ENTRIES(ROBOTSKIN_ENTRY)
#undef ROBOTSKIN_ENTRY
};

struct EntryHeader {
  std::uint32_t bytes;  // of the payload, without padding
  std::uint16_t kind;
  std::uint16_t flags;  // of a command: `ended_by_clock`
  std::int64_t time_ns;
};
static_assert(sizeof(EntryHeader) == 16);

// A flag of a command: a clock ended the fusion of its tick, so that nothing repeats it.
inline constexpr std::uint16_t ended_by_clock = 1;

constexpr std::size_t entry_bytes(std::size_t payload) {
  return sizeof(EntryHeader) + (payload + 7) / 8 * 8;
}

class Tape {
 public:
  // Each has a place of its own; what all have passed makes room.
  static constexpr std::size_t readers = 2;

  // The tape in a piece of memory, aligned to 64 bytes, that outlives it; `fresh`: an empty one, which nothing reads.
  // Its capacity is the largest power of two that has room. std::invalid_argument: the memory is too small or askew.
  Tape(std::span<std::uint8_t> memory, bool fresh);

  // ---- The thread that writes ----

  // Copies an entry of several parts; false and counted where there is no room.
  bool put(Entry kind, std::int64_t time_ns, std::span<const std::span<const std::uint8_t>> parts,
           std::uint16_t flags = 0) noexcept;
  bool put(Entry kind, std::int64_t time_ns, std::span<const std::uint8_t> payload) noexcept {
    return put(kind, time_ns, std::span(&payload, 1));
  }

  // ---- The thread of a reader ----

  // Appends whole entries to `out`, at most `bytes_max` bytes of them; how many bytes.
  std::size_t drain(std::size_t reader, std::vector<std::uint8_t>& out, std::size_t bytes_max);

  // ---- Any thread, of any process ----

  // What is written from now on waits for this reader. Call it before the first drain, in the process that writes.
  void begin_reading(std::size_t reader) noexcept;
  // Nothing waits for it any more.
  void end_reading(std::size_t reader) noexcept;
  std::uint64_t dropped() const { return head_->dropped.load(std::memory_order_relaxed); }
  std::size_t capacity() const { return capacity_; }

 private:
  struct alignas(64) Place {
    std::atomic<std::uint64_t> first{0};
    std::atomic<std::uint64_t> reads{0};
  };
  struct Head {
    std::uint64_t untold = 0;  // dropped since the last entry that found room
    std::atomic<std::uint64_t> dropped{0};
    alignas(64) std::atomic<std::uint64_t> last{0};
    std::array<Place, readers> place;
  };
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

  std::size_t used(std::size_t last) const noexcept;
  void copy(std::size_t at, const void* from, std::size_t bytes) noexcept;

  Head* head_;
  std::size_t capacity_;
  std::uint8_t* bytes_;
};

}  // namespace robotskin::record
