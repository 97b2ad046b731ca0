# SPDX-License-Identifier: Apache-2.0
"""A skinned robot reduced to what control is about: MuJoCo's physics, the robot's port, a controller, and a skin that
feels what is true a few milliseconds late. The network in between has benchmarks of its own.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from robotskin import robots
from robotskin.control import Behaviour, Controller
from robotskin.cycle import SafetyState
from robotskin.layout import finished
from robotskin.model import CommandMode, JointCommand, JointState, RobotDynamics
from robotskin.robots.gains import GainSet
from robotskin.skin import Health, SkinState
from robotskin.world import World
from robotskin.world.scene import HandSpec

Array = NDArray[np.float64]
PERIOD_S = 0.001
SKIN_DELAY_TICKS = 4
"""From touch to skin state: half a sample at 250 Hz and the transport of a large skin."""
PROXIMITY_COVER_M = 0.006
PROXIMITY_REACH_M = 0.2


class ControlRig:
    """One robot, one controller.

    Args:
        name: of a robot with gains and a finished layout.
        behaviour, interface: to begin with.
        seed: of the world.
        hands: that can touch the robot.
        self_collision: the controller knows the robot's surfaces, so that behaviours by name keep its bodies apart.
    """

    def __init__(
        self,
        name: str,
        behaviour: str | Behaviour,
        interface: str,
        seed: int,
        *,
        hands: int = 1,
        self_collision: bool = False,
    ) -> None:
        self.robot, self.layout = robots.load(name), finished(name)
        self.gains = GainSet.load(name)
        self.world = World(
            self.layout, self.robot, seed, posture=self.gains.home, powered=False, hands=[HandSpec()] * hands
        )
        self.model = self.layout.skin_model()
        body = self.robot if self_collision else None
        self.controller = Controller(self.robot.core, self.model, self.gains, behaviour, body=body)
        self.controller.request_mode(CommandMode[interface])
        self.joints = JointState(self.robot.joint_count)
        self.command = JointCommand(CommandMode[interface], self.robot.joint_count)
        self.skin = SkinState(len(self.layout))
        self.skin.health[:] = Health.alive.value
        self.ball: tuple[Array, float] | None = None
        """Centre in the base frame and radius, metres, of a ball that cells sense and nothing else meets."""
        self._felt: deque[tuple[Array, Array]] = deque()
        self._dynamics = RobotDynamics(self.robot.core)
        self._push: tuple[int, Array, Array, float] | None = None
        self._feeling = np.array([], dtype=int)
        self.controller.request_run(True)
        self.run(0.1)

    def run(self, seconds: float) -> None:
        """Step for a time."""
        for _ in range(round(seconds / PERIOD_S)):
            self.step()

    def step(self) -> None:
        """One control period."""
        self._apply_push()
        self.world.step(PERIOD_S)
        self._feel()
        self.world.port.read(self.joints)
        now_ns = self.world.now_ns
        self.skin.time_ns = now_ns
        report = self.controller.step(self.joints, self.skin, now_ns, self.command)
        if report.send:
            self.world.port.write(self.command)
        elif report.stop_port:
            self.world.port.stop()

    @property
    def running(self) -> bool:
        """Whether the controller obeys, and has not been stopped by the guard."""
        return self.controller.report.state in (SafetyState.running, SafetyState.degraded)

    # ---- Touch ----

    def push(self, cell: int, force_n: float, *, wide: bool = False) -> None:
        """Push a cell without friction: a force along its inward normal, which turns with the cell.

        A `wide` push is felt by the cell and its neighbours alike.
        """
        self._push = self._push_on(cell, force_n) if force_n > 0 else None
        beside = self.layout.neighbours[cell, :, 0] if wide else np.array([], dtype=int)
        self._feeling = np.array([cell, *beside[beside >= 0]])

    def _push_on(self, cell: int, force_n: float) -> tuple[int, Array, Array, float]:
        """Body, point and force in that body's frame, and newton."""
        data, body = self.world.scene.data, self.world.scene.cell_body[cell]
        pose = self.world.body.world_from_cell().reshape(-1, 4, 4)[cell]
        body_from_world = data.xmat[body].reshape(3, 3).T
        point = body_from_world @ (pose[:3, 3] - data.xpos[body])
        return body, point, body_from_world @ pose[:3, 2] * -force_n, force_n

    def _apply_push(self) -> None:
        data = self.world.scene.data
        data.xfrc_applied[:] = 0
        if self._push is None:
            return
        body, point, force, _ = self._push
        turn = data.xmat[body].reshape(3, 3)
        x, y, z = turn @ point + data.xpos[body] - data.xipos[body]
        along = turn @ force
        data.xfrc_applied[body, :3] = along
        data.xfrc_applied[body, 3:] = (
            y * along[2] - z * along[1],
            z * along[0] - x * along[2],
            x * along[1] - y * along[0],
        )

    def _feel(self) -> None:
        force = self.world.cell_true_force()
        if self._push is not None:
            force[self._feeling] += self._push[3] / 3 / len(self._feeling)
        near = np.zeros(len(self.layout))
        if self.ball is not None:
            distance = np.maximum(self._along_normals(), 0)
            share = (PROXIMITY_COVER_M / (PROXIMITY_COVER_M + distance)) ** 2
            near = np.where(distance <= PROXIMITY_REACH_M, share, 0.0)
        self._felt.append((force, near))
        if len(self._felt) > SKIN_DELAY_TICKS:
            late_force, late_near = self._felt.popleft()
            self.skin.normal_force[:] = np.minimum(late_force, 10.0)
            self.skin.proximity[:] = late_near

    def _along_normals(self) -> Array:
        """(N,) metres from each cell along its normal to the ball, inf where the normal misses it."""
        assert self.ball is not None
        centre, radius = self.ball
        pose = self.world.base_from_cell()
        to_centre = centre - pose[:, :3, 3]
        along = (to_centre * pose[:, :3, 2]).sum(axis=1)
        aside = radius**2 - (to_centre**2).sum(axis=1) + along**2
        with np.errstate(invalid="ignore"):
            return np.where((aside > 0) & (along > 0), along - np.sqrt(aside), np.inf)

    def gap_m(self) -> float:
        """Metres between the ball and the nearest cell, 0 and less: it touches."""
        assert self.ball is not None
        centre, radius = self.ball
        return float(np.linalg.norm(self.world.base_from_cell()[:, :3, 3] - centre, axis=1).min() - radius)

    # ---- What is known ----

    def place(self, cell: int) -> Array:
        """(3,) metres: where a cell is."""
        return self.world.base_from_cell(cell)[:3, 3]

    def normal(self, cell: int) -> Array:
        """(3,) the outward normal of a cell, base frame."""
        return self.world.base_from_cell(cell)[:3, 2]

    def contact_n(self) -> float:
        """Newton, MuJoCo's contact force of all hands on the skin."""
        return float(self.world.contact_normal_force().sum())

    def soft_cells(self, count: int, rng: np.random.Generator) -> list[int]:
        """Cells that the skin task can move: their weight is none of the bounds."""
        weight = self.gains.force_weights(self.robot.core, self.model)
        stiff = self.gains.stiff_compliance(self.robot.core, self.model)
        soft = np.flatnonzero(stiff * (1 + weight) > 0.6 * self.gains.values["skin"]["compliance_m_per_n"])
        return [int(cell) for cell in rng.choice(soft, min(count, len(soft)), replace=False)]
