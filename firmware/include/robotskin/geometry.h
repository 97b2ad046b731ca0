/* SPDX-License-Identifier: Apache-2.0
 * The shape of a cell, in the cell frame: origin at the centre of the outer face, z the outward normal.
 *
 * Two cells joined by a flexible hinge share the hinge point: t = a_p - R a_q, where a_p is the port point of the
 * one, a_q that of the other and R the rotation between them. Flat neighbours on ports 1-4 and 2-3 are 27.78 mm apart.
 */
#ifndef ROBOTSKIN_GEOMETRY_H
#define ROBOTSKIN_GEOMETRY_H

enum { RS_PORTS = 4 }; /* Ports are numbered 1 to 4; arrays hold port p at index p - 1. */

/* X(port, x in micrometres, y in micrometres) */
#define RS_PORT_POINTS(X) \
  X(1, 12000, 7000)       \
  X(2, 12000, -7000)      \
  X(3, -12000, 7000)      \
  X(4, -12000, -7000)

#define RS_HEXAGON_SIDE_UM \
  14000 /* side of the rigid hexagon; corners on the x axis, flats face the lattice neighbours, 24.2 mm across */
#define RS_LATTICE_PITCH_UM 28000 /* distance of neighbours in the flat lattice */
#define RS_CELL_THICKNESS_UM 3600 /* rigid cell without its foam layer */
#define RS_HINGE_REACH_UM 3700    /* widest gap that the flexible joint spans */

/* The three force sensors, X(sensor, x in micrometres, y in micrometres): an equilateral triangle on the face. */
#define RS_FORCE_SENSOR_POINTS(X) \
  X(1, 0, 6500)                   \
  X(2, -5629, -3250)              \
  X(3, 5629, -3250)

#endif
