// SPDX-License-Identifier: Apache-2.0
// A table that one thread writes and one other thread reads, and neither ever waits.
//
// Three buffers: one belongs to the writer, one to the reader, one lies between them and changes hands by an atomic
// exchange. The writer keeps a master copy and, for each buffer, the list of rows that have changed since that buffer
// was last its own, so that a publication costs as much as has changed and not as much as there is.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace robotskin::driver {

template <class Row>
class SnapshotTable {
 public:
  explicit SnapshotTable(std::size_t rows) : master_(rows), outdated_in_(rows, 0) {
    for (Buffer& buffer : buffers_) buffer.rows.resize(rows);
    for (Outdated& list : outdated_) list.rows.resize(rows);
  }

  std::size_t size() const { return master_.size(); }

  // ---- Writer ----

  const Row& row(std::size_t index) const { return master_[index]; }

  // Tells the processor that the row will be needed soon.
  void prefetch(std::size_t index) const {
    __builtin_prefetch(&master_[index], 1);
    __builtin_prefetch(&outdated_in_[index], 1);
  }

  // The row, to be changed; it will be part of the next publication.
  Row& change(std::size_t index) {
    std::uint8_t& in = outdated_in_[index];
    if (in != 0b111) {
      for (unsigned buffer = 0; buffer < 3; ++buffer) {
        if ((in >> buffer & 1U) == 0) {
          outdated_[buffer].rows[outdated_[buffer].count++] = static_cast<std::uint32_t>(index);
        }
      }
      in = 0b111;
    }
    return master_[index];
  }

  void publish(std::int64_t now_ns) {
    Buffer& buffer = buffers_[back_];
    Outdated& list = outdated_[back_];
    for (std::size_t i = 0; i < list.count; ++i) {
      // The tables of a large skin do not stay in the cache between publications.
      if (i + prefetch_ahead < list.count) {
        const std::uint32_t next = list.rows[i + prefetch_ahead];
        __builtin_prefetch(&buffer.rows[next], 1);
        __builtin_prefetch(&master_[next]);
      }
      const std::uint32_t index = list.rows[i];
      buffer.rows[index] = master_[index];
      outdated_in_[index] &= static_cast<std::uint8_t>(~(1U << back_));
    }
    list.count = 0;
    buffer.published_ns = now_ns;
    buffer.number = ++publications_;
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | fresh), std::memory_order_acq_rel) & ~fresh;
  }

  // Publications so far.
  std::uint64_t publications() const { return publications_; }

  // Sets every row and the count of publications, before anything is read.
  void restore(std::span<const Row> rows, std::uint64_t publications) {
    for (std::size_t i = 0; i < rows.size(); ++i) change(i) = rows[i];
    publications_ = publications;
  }

  // All rows as the writer has them.
  std::span<const Row> rows() const { return master_; }

  // ---- Reader ----

  // The newest publication; it stays as it is until the next call.
  std::span<const Row> read() {
    if (middle_.load(std::memory_order_relaxed) & fresh) {
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & static_cast<std::uint8_t>(~fresh);
    }
    return buffers_[front_].rows;
  }

  // When what `read` returned last was published; 0: nothing has been yet.
  std::int64_t published_ns() const { return buffers_[front_].published_ns; }

  // The number of that publication, counted from 1; 0: nothing has been published yet.
  std::uint64_t publication() const { return buffers_[front_].number; }

 private:
  static constexpr std::size_t prefetch_ahead = 12;
  static constexpr std::uint8_t fresh = 4;  // set in `middle_` if the reader has not seen that buffer

  struct Buffer {
    std::vector<Row> rows;
    std::int64_t published_ns = 0;
    std::uint64_t number = 0;
  };
  struct Outdated {
    std::vector<std::uint32_t> rows;
    std::size_t count = 0;
  };

  std::vector<Row> master_;
  std::vector<std::uint8_t> outdated_in_;  // bit b: the row stands on the list of buffer b
  std::array<Outdated, 3> outdated_;
  std::array<Buffer, 3> buffers_;
  std::uint64_t publications_ = 0;
  std::uint8_t back_ = 0;
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t front_ = 2;
};

}  // namespace robotskin::driver
