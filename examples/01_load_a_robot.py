# SPDX-License-Identifier: Apache-2.0
"""Loads a UR5, prints its joints and what had to be repaired, and checks that it stands where it should."""

import numpy as np

import robotskin as rs

robot = rs.load_robot("ur5")
for name, lower, upper in zip(robot.joint_names, robot.lower, robot.upper, strict=True):
    print(f"{name:20} {lower:6.2f} to {upper:5.2f} rad")
print(f"{len(robot.repairs)} repairs", *robot.repairs, sep="\n")

# At zero the arm is stretched out along x: upper arm 0.425 m and forearm 0.392 m.
wrist = robot.base_from_link(np.zeros(robot.joint_count))[robot.link_index("wrist_1_link")][:3, 3]
assert np.isclose(wrist[0], 0.425 + 0.39225, atol=1e-3), wrist
