# SPDX-License-Identifier: Apache-2.0
"""Behaviour: hold the hand's pose and give way to touch (Cartesian, skin and gravity task)."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), interface="torque")
session.boot()
goal = rs.hand_pose(session)
goal[:3, 3] += [0.0, 0.05, 0.03]
session.controller.go(rs.CartesianGoal(goal, gradually=False))
session.run(seconds=6.0)
error = np.linalg.norm(rs.hand_pose(session)[:3, 3] - goal[:3, 3])
print(f"{session.controller.behaviour.name}: {1e3 * error:.1f} mm from the goal")
assert error < 0.01
session.shut_down()
