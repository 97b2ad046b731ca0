# SPDX-License-Identifier: Apache-2.0
"""A skin on section units and a robot that are really there, in one loop: what `robotskin connect` runs.

In: addresses, keys, a layout, a robot port. Out: a `ConnectedRobot`. What can go wrong before anything moves,
each with what was found and what was expected: nothing there, other keys, another skin, another robot (`ConnectError`,
`UrError`).
"""

from robotskin.connecting.connected_robot import ConnectedRobot
from robotskin.connecting.connected_skin import ConnectedSkin
from robotskin.connecting.errors import ConnectError
from robotskin.connecting.first_checks import check_before_motion
from robotskin.connecting.section_units import SectionUnits, unit_addresses
from robotskin.connecting.touch_order import TouchOrder, marked_cells

__all__ = [
    "ConnectError",
    "ConnectedRobot",
    "ConnectedSkin",
    "SectionUnits",
    "TouchOrder",
    "check_before_motion",
    "marked_cells",
    "unit_addresses",
]
