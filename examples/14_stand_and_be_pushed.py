# SPDX-License-Identifier: Apache-2.0
"""A humanoid on its feet is pushed at its chest: it gives way, brings its weight against the push, and stands."""

import numpy as np

import robotskin as rs

robot = rs.load_robot("talos_standing")
layout = rs.finished_layout("talos_embrace", robot.name)
session = rs.Session(robot, layout)
session.boot()
pose = robot.base_from_link(session.home)[robot.link_index("torso_2_link")] @ layout.link_from_cell
front = np.where(pose[:, 0, 2] > 0.95, pose[:, 2, 3], 0.0) * (layout.link == layout.links.index("torso_2_link"))
cell = int(np.argsort(front)[-4])  # high on the chest, where it faces ahead
before = session.cell_position(cell)
rest = np.array(session.controller.cycle.standing.centre_of_mass)
session.world.push(session.in_world(cell), 20.0)
session.run(seconds=1.5)
balance = session.controller.cycle.standing
back_mm = 1e3 * (before - session.cell_position(cell))[0]
lean_mm = 1e3 * (np.array(balance.centre_of_mass) - rest)[0]
inside_mm = 1e3 * balance.support.inside_by(balance.capture_point)
print(
    f"pushed with {session.felt_force_n():.0f} N, the chest gives way by {back_mm:.0f} mm; the centre of mass goes "
    f"{lean_mm:+.0f} mm ahead, {inside_mm:.0f} mm inside the soles"
)
assert back_mm > 0
assert lean_mm > 5
assert inside_mm > 10
session.shut_down()
