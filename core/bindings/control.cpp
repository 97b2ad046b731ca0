// Binds the control stage.
#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_control(nanobind::module_ /*module*/) {}

}  // namespace robotskin::bindings
