// SPDX-License-Identifier: Apache-2.0
#include "ur/rtde_wire.hpp"

#include <algorithm>

namespace robotskin::ur::rtde {

std::span<std::uint8_t> Splitter::room() noexcept {
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(begin_), bytes_.begin() + static_cast<std::ptrdiff_t>(end_),
            bytes_.begin());
  end_ -= begin_;
  begin_ = 0;
  return std::span(bytes_).subspan(end_);
}

bool Splitter::next(Package& package) noexcept {
  if (broken_ || end_ - begin_ < header_bytes) return false;
  const std::size_t size = static_cast<std::size_t>(bytes_[begin_]) << 8 | bytes_[begin_ + 1];
  if (size < header_bytes || size > package_bytes_max) {
    broken_ = true;
    return false;
  }
  if (end_ - begin_ < size) return false;
  package.kind = static_cast<Kind>(bytes_[begin_ + 2]);
  package.body = std::span<const std::uint8_t>(bytes_).subspan(begin_ + header_bytes, size - header_bytes);
  begin_ += size;
  return true;
}

}  // namespace robotskin::ur::rtde
