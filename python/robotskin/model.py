# SPDX-License-Identifier: Apache-2.0
"""Stage 0: kinematics and dynamics of a robot, joint states, commands, and `RobotPort`, which alone moves it.

In: a URDF. Out: a `RobotModel`, its `RobotDynamics` at a posture. A port of your own derives from `RobotPort`.
"""

from robotskin._core.model import *  # noqa: F403
