# SPDX-License-Identifier: Apache-2.0
"""Behaviour: move the hand along a line; a touch moves it aside (spline Cartesian, skin Cartesian, gravity task)."""

import numpy as np

from robotskin import layout, robots
from robotskin.control import CartesianGoal
from robotskin.session import Session
from robotskin.session.goals import hand_pose

session = Session(robots.load("ur5"), layout.finished("ur5"), interface="position")
session.boot()
goal = hand_pose(session)
goal[:3, 3] += [0.05, -0.08, 0.04]
session.controller.go(CartesianGoal(goal))
session.run(seconds=8.0)
error = np.linalg.norm(hand_pose(session)[:3, 3] - goal[:3, 3])
print(f"{session.controller.behaviour.name}: {1e3 * error:.1f} mm from the goal")
assert error < 0.01
session.shut_down()
