// SPDX-License-Identifier: Apache-2.0
#include "record/recorder.hpp"

#include "record/felt_state.hpp"

namespace robotskin::record {
namespace {

template <class Item>
std::span<const std::uint8_t> bytes_of(std::span<const Item> items) {
  return {reinterpret_cast<const std::uint8_t*>(items.data()), items.size_bytes()};
}

}  // namespace

void DriverTape::accepted(std::span<const std::uint8_t> datagram, std::int64_t now_ns) noexcept {
  if (keyframe_publication() == 0) return;  // nothing before the first keyframe can be replayed
  put(Entry::datagram, now_ns, datagram);
}

void DriverTape::sampled(const driver::Sample& sample) noexcept {
  put(Entry::sample, sample.stamp_ns, {reinterpret_cast<const std::uint8_t*>(&sample), sizeof sample});
}

void DriverTape::published(const driver::Driver& driver, std::uint64_t number, std::int64_t now_ns) noexcept {
  if (keyframe_publication() != 0) {
    put(Entry::publication, now_ns, {reinterpret_cast<const std::uint8_t*>(&number), sizeof number});
  }
  const bool due = keyframe_due_.load(std::memory_order_acquire) || now_ns - keyframe_ns_ >= keyframe_period_ns;
  if (!lost_ && !due) return;
  const driver::Driver::KeyframeParts parts = driver.keyframe_parts();
  if (!tape_.put(Entry::keyframe, now_ns, parts)) return;  // the next publication tries again
  keyframe_due_.store(false, std::memory_order_release);
  keyframe_ns_ = now_ns;
  lost_ = false;
  keyframe_publication_.store(number, std::memory_order_release);
}

void ControlTape::reading(const skin::SkinReader& reader, std::uint64_t number, std::int64_t now_ns) noexcept {
  const std::uint64_t keyframe = driver_.keyframe_publication();
  if (keyframe == 0 || number < keyframe) return;
  if (keyframe != keyframe_) {
    const auto parts = reader.keyframe_parts();
    if (!tape_.put(Entry::reader_keyframe, now_ns, parts)) return;
    keyframe_ = keyframe;
    tare_untold_ns_ = 0;  // the keyframe holds it
    zeroed(reader.force_offset(), now_ns);
  }
  if (tare_untold_ns_ > 0) {
    const auto bytes = bytes_of(std::span<const std::int64_t>(&tare_untold_ns_, 1));
    put(Entry::tare, now_ns, std::span(&bytes, 1));
    tare_untold_ns_ = 0;
  }
  const auto bytes = bytes_of(std::span<const std::uint64_t>(&number, 1));
  put(Entry::read, now_ns, std::span(&bytes, 1));
}

void ControlTape::taring(std::int64_t duration_ns) noexcept {
  tare_untold_ns_ = duration_ns;
}

void ControlTape::zeroed(std::span<const std::array<float, 3>> force_offset, std::int64_t now_ns) noexcept {
  const auto bytes = bytes_of(force_offset);
  put(Entry::force_zero, now_ns, std::span(&bytes, 1));
}

void ControlTape::felt(const skin::SkinState& state, std::int64_t fresh_ns, std::int64_t now_ns) noexcept {
  put(Entry::felt, now_ns, FeltParts(state, fresh_ns).spans());
}

void ControlTape::nothing_felt(std::int64_t now_ns) noexcept {
  put(Entry::nothing_felt, now_ns, {});
}

void ControlTape::joints(std::int64_t stamp_ns, std::span<const double> position, std::span<const double> velocity,
                         std::span<const double> effort) noexcept {
  const std::span<const std::uint8_t> parts[] = {bytes_of(position), bytes_of(velocity), bytes_of(effort)};
  put(Entry::joints, stamp_ns, parts);
}

void ControlTape::command(std::int64_t now_ns, std::uint64_t mode, std::span<const double> values,
                          bool by_clock) noexcept {
  const std::span<const std::uint8_t> parts[] = {{reinterpret_cast<const std::uint8_t*>(&mode), sizeof mode},
                                                 bytes_of(values)};
  put(Entry::command, now_ns, parts, by_clock ? ended_by_clock : 0);
}

}  // namespace robotskin::record
