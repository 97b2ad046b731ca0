// Binds the model stage.
#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_model(nanobind::module_ /*module*/) {}

}  // namespace robotskin::bindings
