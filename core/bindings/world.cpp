// Binds the world stage.
#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_world(nanobind::module_ /*module*/) {}

}  // namespace robotskin::bindings
