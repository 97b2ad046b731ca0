# SPDX-License-Identifier: Apache-2.0
"""Behaviour: teaching by hand, the robot goes where it is pushed and stays there (skin and gravity task)."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), "kinesthetic_joint", interface="position")
session.boot()
cell = rs.pushed_cell(session, "forearm_link")
start = session.cell_position(cell)
session.world.push(cell, force_n=10.0)
session.run(seconds=2.0)
session.world.release()
session.run(seconds=1.0)
moved_m = np.linalg.norm(session.cell_position(cell) - start)
print(f"the arm was led {1e3 * moved_m:.0f} mm and stayed there")
assert moved_m > 0.03
session.shut_down()
