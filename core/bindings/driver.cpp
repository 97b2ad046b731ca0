// Binds the driver stage.
#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_driver(nanobind::module_ /*module*/) {}

}  // namespace robotskin::bindings
