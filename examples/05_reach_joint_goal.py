# SPDX-License-Identifier: Apache-2.0
"""Behaviour: move to a posture along a spline, compliant on the way (spline joint, skin and gravity task)."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), interface="velocity")
session.boot()
goal = session.home + np.array([0.3, 0.1, -0.2, 0.1, 0.0, 0.2])
session.controller.go(rs.JointGoal(goal))
session.run(seconds=5.0)
error = np.abs(np.array(session.joints.position) - goal).max()
print(f"{session.controller.behaviour.name}: {np.rad2deg(error):.2f}° from the goal")
assert error < 0.01
session.shut_down()
