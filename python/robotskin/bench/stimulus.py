"""Hands that keep a skin busy, the same for every run of one seed."""

import numpy as np

from robotskin._core.model import CommandMode, JointCommand
from robotskin.world import HandSpec, World


def hands(count: int, radius_m: float = 0.03) -> tuple[HandSpec, ...]:
    """As many equal hands."""
    return tuple(HandSpec(radius_m=radius_m) for _ in range(count))


class Stimulus:
    """Each hand goes to another cell every `period_s` and pushes it or hovers over it; the robot sways meanwhile.

    Call `drive` before every step of the world.
    """

    def __init__(self, world: World, seed: int, period_s: float = 0.5, sway_rad_s: float = 0.2) -> None:
        self._world = world
        self._random = np.random.default_rng(seed)
        self._period_s = period_s
        joints = world.robot_model.joint_count
        self._sway = self._random.uniform(-sway_rad_s, sway_rad_s, joints)
        self._next_s = [world.time_s + period_s * k / max(len(world.hands), 1) for k in range(len(world.hands))]
        self._command = JointCommand(CommandMode.velocity, joints)
        self._start_s = world.time_s

    def drive(self, time_s: float) -> None:
        """Give every hand whose time has come its next task."""
        for index, hand in enumerate(self._world.hands):
            if time_s < self._next_s[index]:
                continue
            self._next_s[index] += self._period_s
            cell = int(self._random.integers(len(self._world.layout)))
            if self._random.random() < 0.5:
                hand.push(cell, float(self._random.uniform(3, 15)))
            else:
                hand.approach(cell, float(self._random.uniform(0.002, 0.05)), 0.3)
        self._command.value = self._sway * np.sin(2 * np.pi * (time_s - self._start_s))
        self._world.port.write(self._command)
