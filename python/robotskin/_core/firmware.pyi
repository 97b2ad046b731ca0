"""Stages 1 to 3: wire format and firmware of cell and section unit."""

import numpy

PORT_POINTS_M: numpy.ndarray = ...

FORCE_SENSOR_POINTS_M: numpy.ndarray = ...

HEXAGON_SIDE_M: float = 0.013999999999999999

LATTICE_PITCH_M: float = 0.027999999999999997

CELL_THICKNESS_M: float = 0.0036

HINGE_REACH_M: float = 0.0036999999999999997

ID_FIRST: int = 1

ID_LAST: int = 16382

ID_NONE: int = 0

ID_SECTION_UNIT: int = 16383

CELLS_PER_PORT: int = 66

SECTION_UNIT_PORTS_MAX: int = 15

HOST_PORT: int = 1337

SECTION_UNIT_PORT: int = 1336
