# SPDX-License-Identifier: Apache-2.0
"""Behaviour: move the hand along a line; a touch moves it aside (spline Cartesian, skin Cartesian, gravity task)."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), interface="position")
session.boot()
goal = rs.hand_pose(session)
goal[:3, 3] += [0.05, -0.08, 0.04]
session.controller.go(rs.CartesianGoal(goal))
session.run(seconds=8.0)
error = np.linalg.norm(rs.hand_pose(session)[:3, 3] - goal[:3, 3])
print(f"{session.controller.behaviour.name}: {1e3 * error:.1f} mm from the goal")
assert error < 0.01
session.shut_down()
