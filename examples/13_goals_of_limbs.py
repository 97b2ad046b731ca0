# SPDX-License-Identifier: Apache-2.0
"""Goals of several limbs at once: one arm reaches a pose as a hand leads the other (mobile dual-arm robot)."""

import numpy as np

import robotskin as rs

layout = rs.finished_layout("dual_arm")
session = rs.Session(rs.load_robot("dual_arm"), layout, interface="velocity")
session.boot()
goal = rs.hand_pose(session)
goal[:3, 3] += [0.04, 0.0, 0.06]
session.controller.go(rs.LimbGoals({"left_arm": rs.CartesianGoal(goal), "right_arm": rs.ForceGoal()}))
forearm = np.flatnonzero(layout.link == layout.links.index("right_forearm_link"))
session.world.push(session.in_world(int(forearm[len(forearm) // 2])), 8.0)
session.run(seconds=2.0)
session.world.release()
session.run(seconds=4.0)
error = np.linalg.norm(rs.hand_pose(session)[:3, 3] - goal[:3, 3])
right = [name.startswith("right") for name in session.robot.joint_names]
led = np.abs(np.array(session.joints.position) - session.home)[right].max()
print(
    f"{session.controller.behaviour.name}: left hand {1e3 * error:.1f} mm from its goal, right arm led by {led:.2f} rad"
)
assert error < 0.01
assert led > 0.02
session.shut_down()
