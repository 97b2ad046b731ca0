// SPDX-License-Identifier: Apache-2.0
// The frames of cells in a datagram to the host.
#pragma once

#include <cstdint>
#include <span>

#include "robotskin/datagram.h"

namespace robotskin::campaign {

// Calls `each` with every frame, content alone, of a whole datagram that carries frames.
template <typename Call>
void for_each_frame(std::span<const std::uint8_t> datagram, Call&& each) {
  rs_datagram_header header;
  if (rs_datagram_header_unpack(&header, datagram.data(), static_cast<std::uint32_t>(datagram.size())) !=
          RS_DATAGRAM_OK ||
      header.kind != RS_DATAGRAM_KIND_frames)
    return;
  const std::uint8_t* record_at = datagram.data() + RS_DATAGRAM_HEADER_BYTES;
  for (unsigned i = 0; i < header.count; ++i, record_at += RS_DATAGRAM_RECORD_BYTES) each(record_at);
}

}  // namespace robotskin::campaign
