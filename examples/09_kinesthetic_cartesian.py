# SPDX-License-Identifier: Apache-2.0
"""Behaviour: teaching by hand, the robot's hand goes where its arm is pushed (skin Cartesian and gravity task)."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), "kinesthetic_cartesian", interface="velocity")
session.boot()
cell = rs.pushed_cell(session, "forearm_link")
push = -session.world.base_from_cell(cell)[:3, 2]
start = rs.hand_pose(session)[:3, 3]
session.world.push(cell, force_n=10.0)
session.run(seconds=1.5)
moved = rs.hand_pose(session)[:3, 3] - start
print(f"the hand was led {1e3 * np.linalg.norm(moved):.0f} mm")
assert moved @ push > 0.5 * np.linalg.norm(moved) > 0.005
session.shut_down()
