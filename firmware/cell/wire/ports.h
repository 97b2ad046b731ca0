/* SPDX-License-Identifier: Apache-2.0
 * Sets of ports, a bit each: ports are indices 0 to 3 inside a cell. */
#ifndef ROBOTSKIN_CELL_WIRE_PORTS_H
#define ROBOTSKIN_CELL_WIRE_PORTS_H

#include "robotskin/geometry.h"

enum { RS_ALL_PORTS = (1 << RS_PORTS) - 1 };

#endif
