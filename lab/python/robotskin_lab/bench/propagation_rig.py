# SPDX-License-Identifier: Apache-2.0
"""A pushed robot reduced to its control core: joints go where they are told, one cell feels a palm that follows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.control import FEEDFORWARD, Behaviour, Controller, Fusion, TaskLibrary
from robotskin.control.task_library import propagated_compliance
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState, RobotDynamics, RobotModel
from robotskin.robots.gains import ChosenGains, GainSet
from robotskin.robots.limbs import limbs_of
from robotskin.skin import Health, SkinState
from robotskin.tasks import ContactImpedanceGains, Limb, PropagationGains, Task

Array = NDArray[np.float64]
PERIOD_S = 0.001
ROBOT = "dual_arm"
BASE = "base"
FORCE_N_S = 2.0
"""How fast the palm's force rises: at 20 N/m a desired motion of 0.1 m/s, which the base can follow."""
TOLERANCE_M = 0.02
VARIANTS = ("with", "without", "one programme")


@dataclass(frozen=True)
class Followed:
    """One push of a cell, to the end of its range or to the cap.

    range_m: how far the cell followed its desired motion within the tolerance. up: the vertical part of the push at the
    beginning, 0 to 1. base_mm, behind_mm: (3,) the base's longest way from its place, and how far the cell was behind
    its desired motion at most, when that had come 0.1, 0.2 and 0.3 m; NaN where it did not come so far.
    """

    range_m: float
    up: float
    base_mm: Array
    behind_mm: Array
    violations: int


def variant_limbs(robot: RobotModel, variant: str) -> list[Limb]:
    """The limbs of the robot as they are, without the base, or all in one."""
    limbs = limbs_of(robot)
    if variant == "with":
        return limbs
    if variant == "without":
        return [Limb(one.name, one.joints, "", one.largest_acceleration) for one in limbs if one.name != BASE]
    joints = [joint for one in limbs for joint in one.joints]
    return [Limb("robot", joints, "", [value for one in limbs for value in one.largest_acceleration])]


class PropagationRig:
    """The dual-arm robot by velocity, as the control core alone has it."""

    def __init__(self, variant: str = "with", gains: PropagationGains | None = None) -> None:
        self.robot, self.layout = robots.load(ROBOT), finished(ROBOT)
        self.model, self.gains = self.layout.skin_model(), GainSet.load(ROBOT)
        self.chosen = gains or PropagationGains()
        self.controller = Controller(self.robot.core, self.model, self.gains, "propagated_compliance")

        def make(library: TaskLibrary, chosen: ChosenGains) -> Task:
            return propagated_compliance(library, chosen, variant_limbs(self.robot.core, variant), self.chosen)

        self.controller.library.add("variant", make)
        tasks = {"variant": 0, "gravity": FEEDFORWARD}
        self.controller.use(Behaviour("variant", tasks, Fusion.weighted_sum, gains="skin_compliance"))
        self.controller.request_mode(CommandMode.velocity)
        n = self.robot.joint_count
        self.joints, self.command = JointState(n), JointCommand(CommandMode.velocity, n)
        self.joints.position = self.gains.home
        self.skin = SkinState(len(self.layout))
        self.skin.health[:] = Health.alive.value
        self.now_ns = 10**9
        self.dynamics = RobotDynamics(self.robot.core)
        self._at_rest = np.zeros(n)
        self.base_joints = [self.robot.joint_index(name) for name in ("base_x", "base_y")]

    def tick(self) -> None:
        """One period; the joints do what they are told."""
        self.now_ns += 1_000_000
        self.joints.stamp_ns = self.skin.time_ns = self.now_ns
        report = self.controller.step(self.joints, self.skin, self.now_ns, self.command)
        velocity = self.command.value.copy() if report.send else self._at_rest
        self.joints.velocity = velocity
        self.joints.position = self.joints.position + PERIOD_S * velocity

    def restart(self, posture: Array | None = None) -> None:
        """Begin anew at a posture, by default at home."""
        self.skin.normal_force[:] = 0
        self.skin.proximity[:] = 0
        self.controller.request_run(False)
        for _ in range(1000):
            self.tick()
        self.joints.position = self.gains.home if posture is None else posture
        for _ in range(5):
            self.tick()
        self.controller.request_run(True)
        for _ in range(300):
            self.tick()

    def feel(self, cell: int, force_n: float) -> None:
        """Let a cell feel a force."""
        self.skin.normal_force[cell] = force_n / 3

    def cell_place(self, cell: int) -> Array:
        """(4, 4) of a cell in the base frame, where the robot is now."""
        self.dynamics.update(np.ascontiguousarray(self.joints.position), self._at_rest)
        link = self.robot.link_index(self.layout.links[self.layout.link[cell]])
        return self.dynamics.base_from_link(link) @ self.layout.link_from_cell[cell]

    def cell_on(self, link: str, inward: Array) -> int:
        """The cell of a link whose inward normal points most in a direction, at home."""
        self.joints.position = self.gains.home
        cells = [cell for cell, row in enumerate(self.layout.link) if self.layout.links[row] == link]
        normals = np.array([-self.cell_place(cell)[:3, 2] for cell in cells])
        return cells[int(np.argmax(normals @ inward))]

    def base_way_m(self) -> float:
        """How far the base is from where it began."""
        return float(np.linalg.norm(np.asarray(self.joints.position)[self.base_joints]))

    def follow_pair(self, cell: int, cap_m: float) -> float:
        """The range of a cell, pushed with the one of its link that lies farthest, each with half the force."""
        own = self.layout.link_from_cell[:, :3, 3]
        on = np.flatnonzero(np.asarray(self.layout.link) == self.layout.link[cell])
        other = int(on[np.argmax(np.linalg.norm(own[on] - own[cell], axis=1))])
        return self.follow(cell, cap_m, other).range_m

    def follow(self, cell: int, cap_m: float, other: int | None = None) -> Followed:
        """Push a cell along its inward normal, ever harder, until it leaves its desired motion or that reaches the cap.

        The palm stays flat on the cell. Its force gives the desired motion by [Cheng19 eq. 26] alone. With an
        `other` cell each has half of the force, and the motion is that of the point between them.
        """
        cells = [cell] if other is None else [cell, other]
        self.restart()
        impedance: ContactImpedanceGains = self.chosen.impedance
        start = self._between(cells)
        moved, velocity = np.zeros(3), np.zeros(3)
        base_mm, behind_mm, marks = np.full(3, np.nan), np.full(3, np.nan), [0.1, 0.2, 0.3]
        reached = way = behind = 0.0
        for index in range(round(4 * cap_m * impedance.stiffness / FORCE_N_S / PERIOD_S)):
            force = FORCE_N_S * index * PERIOD_S
            place = self._between(cells)
            error = float(np.linalg.norm(start[:3, 3] + moved - place[:3, 3]))
            if error > TOLERANCE_M:
                break
            reached, behind = float(np.linalg.norm(moved)), max(behind, error)
            way = max(way, self.base_way_m())
            for mark, at in enumerate(marks):
                if reached >= at and np.isnan(base_mm[mark]):
                    base_mm[mark], behind_mm[mark] = 1e3 * way, 1e3 * behind
            if reached >= cap_m:
                break
            wrench = -force * place[:3, 2]
            change = (wrench - impedance.damping * velocity - impedance.stiffness * moved) / impedance.inertia
            velocity = velocity + PERIOD_S * change
            moved = moved + PERIOD_S * velocity
            for one in cells:
                self.feel(one, force / len(cells))
            self.tick()
        report = self.controller.report
        return Followed(min(reached, cap_m), abs(float(start[2, 2])), base_mm, behind_mm, int(report.violations))

    def _between(self, cells: list[int]) -> Array:
        """(3, 4) mean of the cells' places: of their points, and of their axes, which are then shorter than 1."""
        return np.asarray(np.mean([self.cell_place(cell) for cell in cells], axis=0)[:3])

    def release(self, seconds: float) -> float:
        """Let go and wait; how far the base is from where it began, mm."""
        self.skin.normal_force[:] = 0
        for _ in range(round(seconds / PERIOD_S)):
            self.tick()
        return 1e3 * self.base_way_m()


def drawn_cells(seed: int, count: int) -> Array:
    """(count,) cells of the skin, drawn evenly without the same twice."""
    cells = len(finished(ROBOT))
    return np.sort(np.random.default_rng([seed, 26]).choice(cells, count, replace=False))
