# SPDX-License-Identifier: Apache-2.0
"""A simulated skin in real time, on an arm that goes where a controller's joints go.

Touches act on the skin alone: the arm that wears it follows the controller stiffly, so that the robot moves only by
what its controller is told.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robotskin.layout import Layout
from robotskin.model import CommandMode, JointCommand
from robotskin.rehearsal.joint_watch import watched
from robotskin.robots import Robot
from robotskin.robots.gains import gains_of
from robotskin.world import World

STEP_S = 0.001


class FollowingWorld:
    """The world from construction to `close`; `run` lets real time pass.

    Args:
        robot: that wears the skin; layout: N cells; seed: of the world.
        controller: whose joints are followed: address of a UR's, or ros2:DOMAIN; None: the robot stands at its home.
        options: further ones of `World`.

    Raises RehearsalError if no controller answers.
    """

    def __init__(self, robot: Robot, layout: Layout, controller: str | None, seed: int, **options: Any) -> None:
        self._joints = None if controller is None else watched(controller, robot)
        if self._joints is not None:
            time.sleep(0.05)
        self._home = gains_of(robot).home
        self.world = World(layout, robot, seed, posture=self._at(), **options)
        self._command = JointCommand(CommandMode.position, robot.joint_count)
        self._due = time.monotonic()

    def _at(self) -> NDArray[np.float64]:
        return self._home if self._joints is None else self._joints.look()

    def run(self, seconds: float) -> None:
        """Let real time pass.

        A world that fell behind catches up, however long it takes: a section unit whose clock had lost time would
        stay stale for the driver until the end of its session.
        """
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            self._command.value = self._at()
            self.world.port.write(self._command)
            self.world.step(STEP_S)
            self.after_step()
            self._due += STEP_S
            ahead = self._due - time.monotonic()
            if ahead > 0:
                time.sleep(ahead)

    def after_step(self) -> None:
        """What is done after each step of the world."""

    def push(self, cell: int, force_n: float) -> None:
        """A hand pushes a cell until `release`."""
        self.world.push(cell, force_n)

    def release(self) -> None:
        """Every hand leaves."""
        self.world.release()

    def force_n(self) -> float:
        """Newton: what the cells truly feel, in sum."""
        return float(self.world.cell_true_force().sum())

    def close(self) -> None:
        """End."""
        if self._joints is not None:
            self._joints.close()
