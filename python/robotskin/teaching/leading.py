# SPDX-License-Identifier: Apache-2.0
"""Leading by the skin: pushes on the arm move the hand, taps on one link open, close and squeeze with the gripper."""

from __future__ import annotations

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

    def look(self, force_n: float, now_s: float) -> Asked:
        """What is asked at this moment; each pair of taps and each press once."""
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
        self._normal = session.layout.link_from_cell[:, :3, 2]
        self._force = np.zeros(3)
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
        force = self.push_n(worker.session)
        self._left_alone_s = 0.0 if force.any() else self._left_alone_s + LOOK_S
        if LET_GO_S <= self._left_alone_s < LET_GO_S + LOOK_S:
            worker.stay()
        self._force += (force - self._force) * min(1.0, LOOK_S / FILTER_S)
        fast = SPEED_M_S_N * float(np.linalg.norm(self._force))
        self.speed_m_s = SPEED_M_S_N * self._force * min(1.0, FASTEST_M_S / max(fast, 1e-9))
        if fast >= 1e-5:
            worker.shift(self.speed_m_s * LOOK_S)

    def push_n(self, session: SkinnedRobot) -> Array:
        """(3,) newton, base axes: how people push the arm; the gripper and its button are left out."""
        force = np.asarray(session.skin.normal_force).sum(axis=1)
        touched = self.leading[force[self.leading] > SILENT_N]
        if not len(touched):
            return np.zeros(3)
        self._dynamics.update(np.array(session.joints.position), np.zeros(session.robot.joint_count))
        total = np.zeros(3)
        for cell in touched:
            turn = self._dynamics.base_from_link(int(self._link[cell]))[:3, :3]
            share = min(1.0, (force[cell] - SILENT_N) / (FULL_N - SILENT_N))
            total -= share * force[cell] * (turn @ self._normal[cell])
        return total

    def _tell_button(self) -> None:
        worker = self.worker
        force = np.asarray(worker.session.skin.normal_force).sum(axis=1)[worker.gripper.button]
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
