// SPDX-License-Identifier: Apache-2.0
#include "record/tape.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>
#include <stdexcept>

namespace robotskin::record {

Tape::Tape(std::span<std::uint8_t> memory, bool fresh) {
  if (memory.size() < sizeof(Head) + 4096 || reinterpret_cast<std::uintptr_t>(memory.data()) % alignof(Head) != 0)
    throw std::invalid_argument("a tape needs memory of 4 KiB and more, aligned to 64 bytes");
  head_ = fresh ? new (memory.data()) Head : reinterpret_cast<Head*>(memory.data());
  capacity_ = std::bit_floor(memory.size() - sizeof(Head));
  bytes_ = memory.data() + sizeof(Head);
}

void Tape::begin_reading(std::size_t reader) noexcept {
  Place& place = head_->place[reader];
  place.first.store(head_->last.load(std::memory_order_acquire), std::memory_order_relaxed);
  place.reads.store(1, std::memory_order_release);
}

void Tape::end_reading(std::size_t reader) noexcept {
  head_->place[reader].reads.store(0, std::memory_order_release);
}

std::size_t Tape::used(std::size_t last) const noexcept {
  std::size_t most = 0;
  for (const Place& place : head_->place)
    if (place.reads.load(std::memory_order_acquire) != 0)
      most = std::max<std::size_t>(most, last - place.first.load(std::memory_order_acquire));
  return most;
}

void Tape::copy(std::size_t at, const void* from, std::size_t bytes) noexcept {
  const std::size_t offset = at & (capacity_ - 1);
  const std::size_t head = std::min(bytes, capacity_ - offset);
  std::memcpy(bytes_ + offset, from, head);
  std::memcpy(bytes_, static_cast<const std::uint8_t*>(from) + head, bytes - head);
}

bool Tape::put(Entry kind, std::int64_t time_ns, std::span<const std::span<const std::uint8_t>> parts,
               std::uint16_t flags) noexcept {
  std::size_t payload = 0;
  for (const auto& part : parts) payload += part.size();
  std::uint64_t& untold = head_->untold;
  const std::size_t gap = untold > 0 ? entry_bytes(sizeof untold) : 0;
  std::size_t last = head_->last.load(std::memory_order_relaxed);
  if (capacity_ - used(last) < gap + entry_bytes(payload)) {
    ++untold;
    head_->dropped.store(dropped() + 1, std::memory_order_relaxed);
    return false;
  }
  const auto begin = [&](Entry which, std::size_t bytes, std::uint16_t own) {
    const EntryHeader header{static_cast<std::uint32_t>(bytes), static_cast<std::uint16_t>(which), own, time_ns};
    copy(last, &header, sizeof header);
    return last + sizeof header;
  };
  if (gap > 0) {
    copy(begin(Entry::gap, sizeof untold, 0), &untold, sizeof untold);
    last += gap;
    untold = 0;
  }
  std::size_t at = begin(kind, payload, flags);
  for (const auto& part : parts) {
    copy(at, part.data(), part.size());
    at += part.size();
  }
  constexpr std::uint64_t zero = 0;
  last += entry_bytes(payload);
  copy(at, &zero, last - at);
  head_->last.store(last, std::memory_order_release);
  return true;
}

std::size_t Tape::drain(std::size_t reader, std::vector<std::uint8_t>& out, std::size_t bytes_max) {
  Place& place = head_->place[reader];
  const std::size_t first = place.first.load(std::memory_order_relaxed);
  const std::size_t last = head_->last.load(std::memory_order_acquire);
  std::size_t end = first;
  while (end != last) {
    std::uint32_t payload = 0;
    std::memcpy(&payload, bytes_ + (end & (capacity_ - 1)), sizeof payload);
    const std::size_t next = end + entry_bytes(payload);
    if (next - first > bytes_max && end != first) break;
    end = next;
  }
  const std::size_t bytes = end - first, offset = first & (capacity_ - 1);
  const std::size_t head = std::min(bytes, capacity_ - offset);
  out.insert(out.end(), bytes_ + offset, bytes_ + offset + head);
  out.insert(out.end(), bytes_, bytes_ + (bytes - head));
  place.first.store(end, std::memory_order_release);
  return bytes;
}

}  // namespace robotskin::record
