# SPDX-License-Identifier: Apache-2.0
"""A task of one's own: the robot gives way to touch, but its hand stays under a ceiling (cpp/own_task.cpp: in C++)."""

import numpy as np

import robotskin as rs

session = rs.Session(rs.load_robot("ur5"), rs.finished_layout("ur5"), interface="velocity")
session.boot()
hand = session.robot.core.link_index("ee_link")
ceiling_m = rs.hand_pose(session)[2, 3] + 0.02


def under_ceiling(dynamics, position, velocity, skin):
    """A spring from 10 mm below the ceiling on: torque (n) Nm, and the motion it claims, which is up: a row (1, n)."""
    too_high_m = max(0.0, dynamics.base_from_link(hand)[2, 3] - (ceiling_m - 0.01))
    up = dynamics.link_jacobian(hand)[2]  # (n) velocity of the hand along z of the base by joint velocity
    return -20000.0 * too_high_m * up, min(1.0, too_high_m / 0.005) * up[None]


session.controller.library.add("ceiling", lambda library, gains: rs.PythonTask("ceiling", 6, 1, under_ceiling))
careful = rs.Behaviour(
    "under_a_ceiling",
    {"ceiling": 0, "joint": 1, "skin": 1, "gravity": rs.FEEDFORWARD},
    rs.Fusion.null_space,
    gains="skin_compliance",
)
height_m = []
for behaviour in ("skin_compliance", careful):
    session.controller.use(behaviour)
    session.world.push(rs.pushed_cell(session, "forearm_link"), force_n=15.0)
    session.run(seconds=1.0)
    height_m.append(rs.hand_pose(session)[2, 3] - ceiling_m)
    session.world.release()
    session.run(seconds=1.5)
free_mm, held_mm = 1e3 * np.array(height_m)
print(f"pushed, the hand rises {free_mm:.0f} mm above the ceiling; with the task it stays {-held_mm:.0f} mm under it")
assert held_mm < 0 < free_mm
session.shut_down()
