// Binds what the firmware headers define: cell geometry, channels and the wire format. Python repeats none of it.
#include <nanobind/ndarray.h>

#include <array>

#include "bindings/bindings.hpp"
#include "robotskin/channels.h"
#include "robotskin/datagram.h"
#include "robotskin/geometry.h"
#include "robotskin/wire.h"

namespace robotskin::bindings {
namespace {

namespace nb = nanobind;

using Points = nb::ndarray<nb::numpy, const double, nb::shape<-1, 2>>;

#define POINT_METRES(port, x_um, y_um) {(x_um) * 1e-6, (y_um) * 1e-6},
constexpr double port_points_m[][2] = {RS_PORT_POINTS(POINT_METRES)};
constexpr double force_sensor_points_m[][2] = {RS_FORCE_SENSOR_POINTS(POINT_METRES)};
#undef POINT_METRES

void bind_geometry(nb::module_& module) {
  module.attr("PORT_POINTS_M") = nb::cast(Points(port_points_m, {RS_PORTS, 2}));
  module.attr("FORCE_SENSOR_POINTS_M") = nb::cast(Points(force_sensor_points_m, {3, 2}));
  module.attr("HEXAGON_SIDE_M") = RS_HEXAGON_SIDE_UM * 1e-6;
  module.attr("LATTICE_PITCH_M") = RS_LATTICE_PITCH_UM * 1e-6;
  module.attr("CELL_THICKNESS_M") = RS_CELL_THICKNESS_UM * 1e-6;
  module.attr("HINGE_REACH_M") = RS_HINGE_REACH_UM * 1e-6;
}

void bind_limits(nb::module_& module) {
  module.attr("ID_FIRST") = int{RS_ID_FIRST};
  module.attr("ID_LAST") = int{RS_ID_LAST};
  module.attr("ID_NONE") = int{RS_ID_NONE};
  module.attr("ID_SECTION_UNIT") = int{RS_ID_SECTION_UNIT};
  module.attr("CELLS_PER_PORT") = int{RS_CELLS_PER_PORT};
  module.attr("SECTION_UNIT_PORTS_MAX") = int{RS_SECTION_UNIT_PORTS_MAX};
  module.attr("HOST_PORT") = int{RS_HOST_PORT};
  module.attr("SECTION_UNIT_PORT") = int{RS_SECTION_UNIT_PORT};
}

}  // namespace

void bind_firmware(nb::module_ module) {
  bind_geometry(module);
  bind_limits(module);
}

}  // namespace robotskin::bindings
