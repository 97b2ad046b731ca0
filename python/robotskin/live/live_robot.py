# SPDX-License-Identifier: Apache-2.0
"""What a simulated and a connected robot share on a thread of their own: what a page may ask of either."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.choices import member
from robotskin.errors import InputError, UnknownNameError
from robotskin.live.own_thread import OwnThread
from robotskin.live.record_switch import RecordSwitch
from robotskin.model import CommandMode
from robotskin.record.facts import Recorded
from robotskin.record.recorder import note
from robotskin.session import SessionError
from robotskin.session.goals import GoalWatch, reference_of
from robotskin.session.skinned_robot import SkinnedRobot
from robotskin.viewer.session_view import Floats, Goal, RobotView, Snapshot

__all__ = ["RATE_WINDOW_S", "LiveRobot"]

RATE_WINDOW_S = 0.5
"""Between two looks at what is counted, and at the goal: whether it is reached shows in what moved since the last."""


class LiveRobot(OwnThread):
    """Everything of a `robotskin.viewer.session_view.SessionView` that needs no world.

    Every method may be called from any thread and returns at once. What cannot be done is refused there, with a
    RobotskinError, and never reaches the thread that moves the robot.
    """

    _snapshot: Snapshot

    def __init__(self, robot: SkinnedRobot, recorded: Recorded, goal: NDArray[np.float64] | None = None) -> None:
        """`goal`: the one that the robot was given before, (n,) rad or m, or (3,) m of the hand; None: none.

        `recorded`: what the page's switch records.
        """
        super().__init__("session", SessionError)
        self._moved = robot
        self.robot: RobotView = robot.robot
        self.layout = robot.layout
        self._recorded = recorded
        self._switch = RecordSwitch(recorded, self._ask)
        self.goals = GoalWatch(robot, goal)
        self._goal = self._look_at_goal()

    def snapshot(self) -> Snapshot:
        """The latest moment."""
        return self._snapshot

    def ask(self, request: Callable[[], object]) -> None:
        """Have something done between two periods, on the session's thread. Raises SessionError if it has ended."""
        self._ask(request)

    def set_interface(self, interface: CommandMode | str) -> None:
        """Command the robot through another interface. Raises SessionError for one that it does not offer."""
        name = interface if interface in self._moved.interfaces else member("interface", CommandMode, interface).name
        if name not in self._moved.interfaces:
            offered = ", ".join(self._moved.interfaces)
            raise SessionError(f"interface {name}: this robot does not offer it; choose from {offered}")
        self._ask(lambda: self._moved.set_interface(name))
        note(self._recorded, f"interface {name}")

    @property
    def behaviours(self) -> dict[str, str]:
        """What the robot can be told to do, and what each means; empty where that is fixed."""
        return self._moved.behaviours

    def set_behaviour(self, behaviour: str) -> None:
        """Do something else; the torque does not jump."""
        if behaviour not in self.behaviours:
            raise UnknownNameError("behaviour", behaviour, self.behaviours or [self._moved.behaviour])
        self._ask(lambda: self._moved.set_behaviour(behaviour))
        note(self._recorded, f"behaviour {behaviour}")

    def set_goal(self, goal: Floats) -> None:
        """Go there: (n,) rad or m of the joints, or (3,) metres of the hand in the base frame.

        Raises InputError for a goal outside of limits or reach, or where the behaviour takes none.
        """
        place = np.array(goal, dtype=float)
        reference = reference_of(self._moved, place)
        self._ask(lambda: self._go(place, reference))
        note(self._recorded, f"goal {' '.join(f'{value:.4f}' for value in place)}")

    def set_skin(self, on: bool) -> None:
        """Let the skin move the robot, or not."""
        self._ask(lambda: self._moved.set_skin(on))
        note(self._recorded, f"skin {'on' if on else 'off'}")

    @property
    def recording(self) -> str:
        """What is recorded, or was last, and where; empty: nothing yet."""
        return self._switch.told

    def record(self, on: bool) -> None:
        """Record into a new file from now on, or end it. Raises RecordError."""
        self._switch.set(on)

    def close(self) -> None:
        """End the thread, and the recording."""
        super().close()
        self._switch.close()

    # ---- On the thread ----

    def _go(self, goal: NDArray[np.float64], reference: NDArray[np.float64]) -> None:
        # The behaviour may have changed since the page asked: then the page shows the goal that it has.
        with contextlib.suppress(InputError):
            self._moved.controller.set_reference(reference)
            self.goals.given(goal)
            self._goal = self._look_at_goal()

    def _look_at_goal(self) -> Goal | None:
        """Where the goal is and how far; a look every `RATE_WINDOW_S`."""
        kind, at, left, told = self.goals.look()
        if not kind or at is None:
            return None
        return Goal(kind, at, self.goals.goal is not None, left, told)
