# SPDX-License-Identifier: Apache-2.0
"""A robot in a state, with a touched skin: what one tick of a task sees."""

import numpy as np
from random_skin import random_posture, random_skin, random_state

from robotskin.model import RobotDynamics, RobotModel
from robotskin.tasks import SkinGains, Task

CELLS = 200
PERIOD_S = 0.001


class Moment:
    """A robot in a state, with a touched skin."""

    def __init__(self, robot: RobotModel, rng: np.random.Generator, at_rest: bool = False) -> None:
        self.robot, self.rng = robot, rng
        self.skin, self.state = random_skin(robot, CELLS, rng), random_state(CELLS, rng)
        self.share = np.ones(CELLS, dtype=np.float32)
        self.gains = SkinGains.uniform(CELLS, 3.0, 20.0, 0.5, 1.5, 0.1, 0.3)
        self.dynamics = RobotDynamics(robot)
        self.move_to(*random_posture(robot, rng))
        if at_rest:
            self.move_to(self.q, np.zeros_like(self.v))

    def move_to(self, q: np.ndarray, v: np.ndarray | None = None) -> None:
        self.q, self.v = q, np.zeros_like(q) if v is None else v
        self.dynamics.update(self.q, self.v)

    def start(self, task: Task) -> None:
        task.start(self.dynamics, self.q, self.v, self.state, self.share, PERIOD_S)

    def update(self, task: Task) -> np.ndarray:
        task.update(self.dynamics, self.q, self.v, self.state, self.share, PERIOD_S)
        return task.torque

    def body_of(self, cell: int) -> int:
        return self.robot.link_joints[self.robot.link_index(self.skin.link_names[self.skin.link[cell]])]

    def touch_only(self, cells: np.ndarray) -> None:
        untouched = np.setdiff1d(np.arange(CELLS), cells)
        self.state.normal_force[untouched] = 0
        self.state.proximity[untouched] = 0


def last_link(robot: RobotModel) -> str:
    """The link that the last joint moves."""
    return robot.link_names[int(np.flatnonzero(robot.link_joints == robot.joint_count - 1)[0])]
