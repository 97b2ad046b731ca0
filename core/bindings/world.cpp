// SPDX-License-Identifier: Apache-2.0
// Binds the world stage.
#include "bindings/world.hpp"

#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_world(nanobind::module_ module) {
  bind_world_body(module);
  bind_world_network(module);
}

}  // namespace robotskin::bindings
