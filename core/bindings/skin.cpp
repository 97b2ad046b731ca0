// Binds the skin stage.
#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_skin(nanobind::module_ /*module*/) {}

}  // namespace robotskin::bindings
