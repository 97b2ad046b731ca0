// SPDX-License-Identifier: Apache-2.0
#include "record/tape.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace robotskin::record {

Tape::Tape(std::size_t capacity_bytes)
    : capacity_(std::bit_ceil(std::max<std::size_t>(capacity_bytes, 4096))),
      bytes_(std::make_unique<std::uint8_t[]>(capacity_)) {}

void Tape::copy(std::size_t at, const void* from, std::size_t bytes) noexcept {
  const std::size_t offset = at & (capacity_ - 1);
  const std::size_t head = std::min(bytes, capacity_ - offset);
  std::memcpy(bytes_.get() + offset, from, head);
  std::memcpy(bytes_.get(), static_cast<const std::uint8_t*>(from) + head, bytes - head);
}

bool Tape::put(Entry kind, std::int64_t time_ns, std::span<const std::span<const std::uint8_t>> parts) noexcept {
  std::size_t payload = 0;
  for (const auto& part : parts) payload += part.size();
  const std::size_t gap = untold_ > 0 ? entry_bytes(sizeof untold_) : 0;
  std::size_t last = last_.load(std::memory_order_relaxed);
  const std::size_t used = last - first_.load(std::memory_order_acquire);
  if (capacity_ - used < gap + entry_bytes(payload)) {
    ++untold_;
    dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return false;
  }
  const auto begin = [&](Entry which, std::size_t bytes) {
    const EntryHeader header{static_cast<std::uint32_t>(bytes), static_cast<std::uint16_t>(which), 0, time_ns};
    copy(last, &header, sizeof header);
    return last + sizeof header;
  };
  if (gap > 0) {
    copy(begin(Entry::gap, sizeof untold_), &untold_, sizeof untold_);
    last += gap;
    untold_ = 0;
  }
  std::size_t at = begin(kind, payload);
  for (const auto& part : parts) {
    copy(at, part.data(), part.size());
    at += part.size();
  }
  constexpr std::uint64_t zero = 0;
  last += entry_bytes(payload);
  copy(at, &zero, last - at);
  last_.store(last, std::memory_order_release);
  return true;
}

std::size_t Tape::drain(std::vector<std::uint8_t>& out, std::size_t bytes_max) {
  const std::size_t first = first_.load(std::memory_order_relaxed);
  const std::size_t last = last_.load(std::memory_order_acquire);
  std::size_t end = first;
  while (end != last) {
    std::uint32_t payload = 0;
    std::memcpy(&payload, bytes_.get() + (end & (capacity_ - 1)), sizeof payload);
    const std::size_t next = end + entry_bytes(payload);
    if (next - first > bytes_max && end != first) break;
    end = next;
  }
  const std::size_t bytes = end - first, offset = first & (capacity_ - 1);
  const std::size_t head = std::min(bytes, capacity_ - offset);
  out.insert(out.end(), bytes_.get() + offset, bytes_.get() + offset + head);
  out.insert(out.end(), bytes_.get(), bytes_.get() + (bytes - head));
  first_.store(end, std::memory_order_release);
  return bytes;
}

}  // namespace robotskin::record
