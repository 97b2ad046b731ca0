// SPDX-License-Identifier: Apache-2.0
// What a fault tells a checker of the network. The checker knows the periods of the protocol, the fault does not.
#pragma once

#include <cstddef>
#include <cstdint>

#include "world/network/fault.hpp"

namespace robotskin::world {

class FaultWitness {
 public:
  virtual ~FaultWitness() = default;

  // Ways may be lost for so long from now on. The repair after it may take `longer_ns` more than others.
  virtual void disturbed(std::int64_t for_ns, std::int64_t longer_ns = 0) = 0;
  // Links of the fault's wires, or of all wires of a cell, may go down although both ends run: `downs` times.
  virtual void links_fall(const Fault& fault, std::int64_t for_ns, std::int32_t downs) = 0;
  // Nothing comes on the fault's wires for so long, though both ends run.
  virtual void silent(const Fault& fault, std::int64_t for_ns) = 0;
  virtual void links_of_cell_fall(std::size_t cell, std::int64_t for_ns, std::int32_t downs) = 0;
  virtual void processor_stuck(std::size_t cell, bool stuck) = 0;
  virtual void memory_overwritten(std::size_t cell) = 0;
  virtual void samples_disturbed(std::int64_t for_ns) = 0;
};

// Ways are repaired as after any change of wires or power.
inline void tell_change(const Fault&, bool, FaultWitness& witness) {
  witness.disturbed(0);
}

}  // namespace robotskin::world
