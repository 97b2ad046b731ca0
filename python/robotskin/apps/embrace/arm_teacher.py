# SPDX-License-Identifier: Apache-2.0
"""A scripted person: two hands push cells of an arm until its forearm lies where they want it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.embrace.arm_leading import LED_RAD_S_NM, ArmLeader
from robotskin.apps.teach.pushing import best_grip, shares_of
from robotskin.session import PERIOD_S, Session

Array = NDArray[np.float64]

COUNTS = np.array([1.0, 1.0, 0.3, 1.0, 1.0, 0.5])
"""How much an error of elbow and wrist counts along each axis: where a forearm lies matters more than its height."""
NEAR_M, PATIENCE_S = 0.012, 8.0
"""A forearm is where it is wanted; and a person contents themselves with less after a while."""
LOOK_PERIODS, LOOKS_A_GRIP = 50, 10
"""Of the session between two looks, and looks after which a grip must have helped."""
HELPED_M, TRIES = 0.003, 3
"""A person contents themselves after so many grips in a row that did not help by so much."""
OFF = 0.5
"""A grip is kept while what it cannot push is a smaller part of what is wanted."""
HARDEST_N, APPROACH_PER_S = 12.0, 2.5
"""Of a push; and what part of the error is pushed away in a second."""
LEAST_REACH = 0.02
"""Metres by rad: cells that move neither elbow nor wrist by more are not pushed."""


class ArmTeacher:
    """Leads the arms of a leader; `step` is one period of session and leader."""

    def __init__(self, session: Session, leader: ArmLeader, step: Callable[[], None]) -> None:
        self.session, self.leader, self._step = session, leader, step

    def lead(self, side: str, elbow: Array, wrist: Array) -> float:
        """Push until elbow and wrist are at places (3,) m, base frame; returns how far the forearm's middle is off."""
        own = self.leader.sides[side]
        robot = self.session.robot
        ends = np.array([robot.link_index(f"arm_{side}_{number}_link") for number in (4, 7)])
        goal = np.array([elbow, wrist])
        grip: tuple[int, int] | None = None
        before, failed = np.inf, 0
        for look in range(round(PATIENCE_S / (LOOK_PERIODS * PERIOD_S))):
            posture = self.session.world.joint_positions()
            points = robot.base_from_link(posture)[ends][:, :3, 3]
            error = COUNTS * (goal - points).ravel()
            if np.linalg.norm(error.reshape(2, 3), axis=1).max() < NEAR_M:
                break
            torques, poses = own.torques(posture)
            move = COUNTS * (torques @ own.jacobians(posture, ends, points).reshape(6, -1).T)
            reach = np.linalg.norm(move, axis=1)
            along = move / np.maximum(reach, 1e-9)[:, None]
            if look % LOOKS_A_GRIP == 0:
                helped = float(np.linalg.norm(error)) < before - HELPED_M
                failed = 0 if helped else failed + 1
                if failed == TRIES:
                    break
                grip = grip if helped else None
                before = float(np.linalg.norm(error))
            if grip is None or shares_of(along[list(grip)], error)[1] > OFF:
                able = np.flatnonzero(reach > LEAST_REACH)
                grip = best_grip(able, along[able], poses[able][:, :3, 3], error, grip or ()).cells
            forces = np.array(shares_of(along[list(grip)], error)[0]) / reach[list(grip)]
            forces *= min(APPROACH_PER_S / LED_RAD_S_NM, HARDEST_N / max(float(forces.max()), 1e-9))
            for hand, cell, force in zip(self.session.world.hands[:2], grip, forces, strict=True):
                hand.push(self.session.in_world(int(own.cells[cell])), float(force))
            for _ in range(LOOK_PERIODS):
                self._step()
        for hand in self.session.world.hands[:2]:
            hand.leave()
        for _ in range(4 * LOOK_PERIODS):
            self._step()
        points = robot.base_from_link(self.session.world.joint_positions())[ends][:, :3, 3]
        return float(np.linalg.norm((points - goal).mean(axis=0)[:2]))
