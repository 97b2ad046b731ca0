// Binds the firmware stage.
#include "bindings/bindings.hpp"

namespace robotskin::bindings {

void bind_firmware(nanobind::module_ /*module*/) {}

}  // namespace robotskin::bindings
