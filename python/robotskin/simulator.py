# SPDX-License-Identifier: Apache-2.0
"""The simulated two ends as they are compiled: the cells' network with its faults, wires, hands and the robot's body.

`robotskin.world` puts them together to one world; most programs need only that.
"""

from robotskin._core.world import *  # noqa: F403
