# SPDX-License-Identifier: Apache-2.0
"""A robot and a skin of one's own: a port and an input in Python, and the loop of every robot between them."""

import numpy as np

import robotskin as rs


class MyArm(rs.RobotPort):
    """Here the driver of a real arm would be called. This one is where its velocity commands bring it."""

    def __init__(self, posture):
        super().__init__(joint_count=len(posture), modes=[rs.CommandMode.velocity])
        self.position, self.velocity, self.now_ns = posture.copy(), np.zeros(len(posture)), 0

    def read(self, state):
        self.now_ns += 1_000_000
        self.position += self.velocity * 1e-3
        state.position, state.velocity, state.stamp_ns = self.position, self.velocity, self.now_ns
        return rs.PortStatus.ok

    def write(self, command):
        self.velocity = command.value.copy()
        return rs.PortStatus.ok

    def stop(self):
        self.velocity[:] = 0


class MySkin(rs.SkinInput):
    """Here another maker's sensors would be read. This one feels 12 N on one cell from the first second on."""

    def read(self, now_ns, state):
        state.health[:], state.stamp_ns[:], state.time_ns = rs.Health.alive.value, now_ns, now_ns
        state.normal_force[100] = 4.0 if now_ns > 10**9 else 0.0
        return rs.InputStatus.ok


robot, skin = rs.load_robot("ur5"), rs.finished_layout("ur5")
home = np.array([0.0, -1.4, 1.5, -1.67, -1.5708, 0.0])
arm = MyArm(home)
mine = rs.SkinnedRobot(robot, skin, arm, MySkin(len(skin)), interface="velocity")
mine.start()
for tick in range(1, 4000):
    report = mine.tick(tick * 1_000_000)  # on a real robot: time.monotonic_ns(), a thousand times a second
turned = np.abs(arm.position - home).max()
print(f"{mine.state.name}: {report.sent} commands; the touch turned a joint by {np.rad2deg(turned):.1f} degrees")
assert turned > 0.02
