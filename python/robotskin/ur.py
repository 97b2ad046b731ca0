# SPDX-License-Identifier: Apache-2.0
"""The port of a UR robot: RTDE and a script on its controller behind `RobotPort`.

In: the address of a controller. Out: a `UrPort`. What can go wrong: nothing there, another robot, local control,
software too old (`UrError`, with what was found and what was expected).
"""

from robotskin._core.ur import *  # noqa: F403
