# SPDX-License-Identifier: Apache-2.0
"""Both arms led by touch: what pushes a cell turns the joints of its arm, and they stay where they are left."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arms import SIDES, Arms
from robotskin.apps.embrace.regulation import LOOK_S, PERIODS
from robotskin.apps.embrace.tasks import use_embrace
from robotskin.layout import Layout
from robotskin.model import RobotDynamics
from robotskin.session import SkinnedRobot

Array = NDArray[np.float64]

LED_RAD_S_NM, FASTEST_RAD_S = 0.1, 0.5
"""How fast a joint turns for a newton metre of the push, and at most."""
SILENT_N = 0.35
FILTER_S = 0.03
"""Of the torque of the pushes."""
INSIDE_RAD = 0.02
"""Kept from the ends of joints."""


class ArmCells:
    """The cells of one arm, C, and the torques by which pushes on them would turn its joints."""

    def __init__(self, arms: Arms, layout: Layout, side: str) -> None:
        self.robot = arms.robot
        self.joints = arms.joints[side]
        names = np.array(layout.links)[layout.link]
        self.cells = np.flatnonzero(np.char.startswith(names, f"arm_{side}_"))
        """(C,) indices in the layout."""
        self._links = np.array([self.robot.link_index(name) for name in names[self.cells]])
        self._link_from_cell = layout.link_from_cell[self.cells]
        self._dynamics = RobotDynamics(self.robot.core)

    def torques(self, posture: Array, rows: NDArray[np.int64] | None = None) -> tuple[Array, Array]:
        """(C, 7) Nm for a newton that presses each cell inward, and poses (C, 4, 4) of the cells, base frame.

        rows: of `cells`, where not all are wanted.
        """
        own = np.arange(len(self.cells)) if rows is None else rows
        links = self._links[own]
        poses = self.robot.base_from_link(posture)[links] @ self._link_from_cell[own]
        jacobians = self.jacobians(posture, links, poses[:, :3, 3])
        return -np.einsum("cij,ci->cj", jacobians, poses[:, :3, 2]), poses

    def jacobians(self, posture: Array, links: NDArray[np.int64], points: Array) -> Array:
        """(P, 3, 7) metres by rad: how points (P, 3) of these links (P,) move with the arm's joints, base frame."""
        self._dynamics.update(np.ascontiguousarray(posture), np.zeros(self.robot.joint_count))
        found, row = np.unique(links, return_inverse=True)
        at_link = np.array([self._dynamics.link_jacobian(int(link)) for link in found])[row][:, :, self.joints]
        arm = points - self.robot.base_from_link(posture)[links][:, :3, 3]
        return np.asarray(at_link[:, :3] + np.cross(at_link[:, 3:], arm[:, :, None], axisa=1, axisb=1, axisc=1))


class ArmLeader:
    """Lets both arms of a robot in its skin that runs be led; call `step` after each of its ticks.

    posture: (n) rad where they begin.
    """

    def __init__(self, session: SkinnedRobot, arms: Arms, posture: Array) -> None:
        self.session, self.arms = session, arms
        self.sides = {side: ArmCells(arms, session.layout, side) for side in SIDES}
        self.reference = np.array(posture)
        """(n) rad that the robot is told."""
        everywhere = np.ones(len(session.layout), dtype=bool)
        self._task = use_embrace(session, everywhere, posture, 0.0, skin=False)
        self._torque = {side: np.zeros(len(arms.joints[side])) for side in SIDES}
        self._limits = session.robot.lower + INSIDE_RAD, session.robot.upper - INSIDE_RAD
        self._tick = 0

    def step(self) -> None:
        """One period of the session."""
        self._tick += 1
        if self._tick % PERIODS:
            return
        force = self.session.cell_forces_n()
        posture = np.array(self.session.joints.position)
        for side, own in self.sides.items():
            touched = np.flatnonzero(force[own.cells] > SILENT_N)
            felt = force[own.cells[touched]]
            torque = felt @ own.torques(posture, touched)[0] if len(touched) else np.zeros(len(own.joints))
            self._torque[side] += (torque - self._torque[side]) * min(1.0, LOOK_S / FILTER_S)
            speed = LED_RAD_S_NM * self._torque[side]
            speed *= min(1.0, FASTEST_RAD_S / max(float(np.abs(speed).max()), 1e-9))
            self.reference[own.joints] += LOOK_S * speed
        self.reference = np.clip(self.reference, *self._limits)
        self._task.request_reference(self.reference)
