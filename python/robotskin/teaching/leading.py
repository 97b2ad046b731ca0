# SPDX-License-Identifier: Apache-2.0
"""Leading by the skin: pushes on the arm move the hand or the joints, taps on one link ask something of the gripper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from robotskin.model import RobotDynamics
from robotskin.session import SkinnedRobot
from robotskin.teaching.behaviours import LED
from robotskin.teaching.touching import let_go, squeeze, take
from robotskin.teaching.worker import LOOK_S, Steps, Worker

Array = NDArray[np.float64]

SPEED_M_S_N, FASTEST_M_S = 0.009, 0.15
"""10 N lead the hand by more than 100 mm in 2 s."""
SPEED_RAD_S_NM, FASTEST_RAD_S = 0.05, 0.4
"""Of a joint that is led by itself; or m/s for a newton, and m/s, of one that slides."""
SILENT_N, FULL_N = 0.35, 0.9
FILTER_S, LET_GO_S = 0.03, 0.2
"""Of the push; and how long it is over before the robot stays where it is."""
TAP_N, LET_GO_N = 1.5, 0.7
TAP_S, PAIR_S, PRESS_S = 0.30, 0.70, 0.60
"""A tap is shorter, the second one of a pair begins sooner; a press that lasts longer squeezes."""


class Asked(StrEnum):
    """What a person asks of the gripper by touch."""

    NOTHING = ""
    TOGGLE = "opens or closes"
    SQUEEZE = "squeezes"


@dataclass
class Button:
    """Tells taps from presses by the force on one link of the arm, look by look."""

    began_s: float | None = None
    tapped_s: float = -np.inf
    asked: bool = False
    waits: bool = False
    """For the button to be let go, before anything counts."""

    def lose(self) -> None:
        """A cell that was pressed is lost: neither that nor its return is a tap."""
        self.began_s, self.tapped_s, self.waits = None, -np.inf, True

    def look(self, force_n: float, now_s: float) -> Asked:
        """What is asked at this moment; each pair of taps and each press once."""
        if self.waits:
            self.waits = force_n >= LET_GO_N
            return Asked.NOTHING
        if self.began_s is None:
            if force_n > TAP_N:
                self.began_s, self.asked = now_s, False
                if now_s - self.tapped_s < PAIR_S:
                    self.tapped_s, self.asked = -np.inf, True
                    return Asked.TOGGLE
            return Asked.NOTHING
        lasted_s = now_s - self.began_s
        if force_n < LET_GO_N:
            if lasted_s < TAP_S and not self.asked:
                self.tapped_s = now_s
            self.began_s = None
        elif lasted_s > PRESS_S and not self.asked:
            self.asked = True
            return Asked.SQUEEZE
        return Asked.NOTHING


class Leader:
    """Lets a worker be led; call `step` after each of the session's periods, instead of the worker's."""

    def __init__(self, worker: Worker) -> None:
        self.worker = worker
        session, gripper = worker.session, worker.gripper
        self.button = Button()
        self.asked = Asked.NOTHING
        """What was asked last."""
        self.closed = False
        self.squeezes: list[object] = []
        """What the squeezes have felt, `Squeezed`, in order."""
        arm = np.ones(len(session.layout), dtype=bool)
        for cells in (*gripper.cells, gripper.button):
            arm[cells] = False
        self.leading = np.flatnonzero(arm)
        self._dynamics = RobotDynamics(session.robot.core)
        self._link = np.array([session.robot.link_index(name) for name in session.layout.links])[session.layout.link]
        self._links = sorted({int(link) for link in self._link[self.leading]})
        self._place = session.layout.link_from_cell[:, :3, 3]
        self._normal = session.layout.link_from_cell[:, :3, 2]
        self.by_joints = False
        """Whether a push turns the joints that it would turn, instead of moving the hand; the gripper tilts then."""
        self._force, self._effort = np.zeros(3), np.zeros(session.robot.joint_count)
        self.speed_m_s = np.zeros(3)
        """(3) how the hand is led at this moment, base axes."""
        self._left_alone_s = 1.0
        worker.use(LED)

    def step(self) -> None:
        """One period of the session: lead, and see what the button is asked."""
        worker = self.worker
        if worker.looks_next:
            self._lead()
            self._tell_button()
        worker.step()

    def _lead(self) -> None:
        worker = self.worker
        pushes = self.pushes(worker.session)
        self._left_alone_s = 0.0 if pushes else self._left_alone_s + LOOK_S
        if LET_GO_S <= self._left_alone_s < LET_GO_S + LOOK_S:
            worker.stay()
        share = min(1.0, LOOK_S / FILTER_S)
        self._force += (_sum_n(pushes) - self._force) * share
        self._effort += (self.effort(pushes) - self._effort) * share
        if self.by_joints:
            self.speed_m_s = np.zeros(3)
            self._turn_joints()
            return
        fast = SPEED_M_S_N * float(np.linalg.norm(self._force))
        self.speed_m_s = SPEED_M_S_N * self._force * min(1.0, FASTEST_M_S / max(fast, 1e-9))
        if fast >= 1e-5:
            worker.shift(self.speed_m_s * LOOK_S)

    def _turn_joints(self) -> None:
        worker, arm = self.worker, self.worker.gripper.arm
        speed = SPEED_RAD_S_NM * self._effort[arm]
        speed *= min(1.0, FASTEST_RAD_S / max(float(np.abs(speed).max(initial=0.0)), 1e-9))
        if np.abs(speed).max(initial=0.0) >= 1e-5:
            robot = worker.session.robot
            worker.wanted[arm] = np.clip(worker.wanted[arm] + speed * LOOK_S, robot.lower[arm], robot.upper[arm])

    def pushes(self, session: SkinnedRobot) -> list[tuple[int, Array]]:
        """By cell, (3) newton, base axes: how people push the arm; the gripper and its button are left out."""
        force = session.cell_forces_n()
        touched = self.leading[force[self.leading] > SILENT_N]
        if not len(touched):
            return []
        self._dynamics.update(np.array(session.joints.position), np.zeros(session.robot.joint_count))
        found = []
        for cell in touched:
            turn = self._dynamics.base_from_link(int(self._link[cell]))[:3, :3]
            share = min(1.0, (force[cell] - SILENT_N) / (FULL_N - SILENT_N))
            found.append((int(cell), -share * force[cell] * (turn @ self._normal[cell])))
        return found

    def effort(self, pushes: Sequence[tuple[int, Array]]) -> Array:
        """(n) Nm or N that these pushes put on the joints, in the posture of `pushes`: Jᵀ f of their cells."""
        found = np.zeros(len(self._effort))
        for cell, force in pushes:
            link = int(self._link[cell])
            lever = self._dynamics.base_from_link(link)[:3, :3] @ self._place[cell]
            found += self._dynamics.link_jacobian(link).T @ np.concatenate([force, np.cross(lever, force)])
        return found

    def _tell_button(self) -> None:
        worker = self.worker
        if worker.has_lost(worker.gripper.button):
            self.button.lose()
            return
        force = worker.session.cell_forces_n()[worker.gripper.button]
        asked = self.button.look(float(force.max(initial=0.0)), worker.now_s)
        if asked is not Asked.NOTHING:
            self.ask(asked)

    def ask(self, asked: Asked) -> None:
        """Let the gripper do this, unless it is at work."""
        worker = self.worker
        if worker.busy:
            return
        self.asked = asked
        if asked is Asked.SQUEEZE:
            worker.begin(self._squeeze())
        elif self.closed:
            self.closed = False
            worker.begin(let_go(worker))
        else:
            worker.begin(self._take())

    def _take(self) -> Steps:
        self.closed = True
        held = yield from take(self.worker)
        return held

    def _squeeze(self) -> Steps:
        if self.closed:
            self.squeezes.append((yield from squeeze(self.worker)))


def _sum_n(pushes: Sequence[tuple[int, Array]]) -> Array:
    return np.sum([force for _, force in pushes], axis=0) if pushes else np.zeros(3)
