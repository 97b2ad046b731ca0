// Binds the robot stage.
#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_robot(nanobind::module_ /*module*/) {}

}  // namespace robotskin::bindings
