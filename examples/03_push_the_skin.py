# SPDX-License-Identifier: Apache-2.0
"""Push a skinned UR5 and let it give way: firmware, wire, UDP, driver and controller are the real ones."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), seed=1, interface="torque")
session.boot()
cell = rs.pushed_cell(session, "forearm_link")
before = session.cell_position(cell)
session.world.push(cell, force_n=15.0)
session.run(seconds=1.5)
gave_way_m = np.linalg.norm(session.cell_position(cell) - before)
print(f"cell {cell} feels {session.felt_force_n():.1f} N and gave way by {1e3 * gave_way_m:.0f} mm")
assert 14.0 < session.felt_force_n() < 16.0
assert 0.03 < gave_way_m < 0.15
session.shut_down()
