# SPDX-License-Identifier: Apache-2.0
"""Goals and behaviours that come by topics of ROS 2: what the page may ask of a session, and no more.

Off unless asked for. What is heard goes to the session as a click on the page does, through the same checks; the
controller's guard stands behind it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from robotskin.errors import InputError, RobotskinError
from robotskin.ros2 import Topic
from robotskin.ros2.dds import DdsNode
from robotskin.ros2.message_types import cdr, short_names
from robotskin.sharing.poses import Floats

GOAL = Topic("/robotskin/goal", "sensor_msgs/msg/JointState")
BEHAVIOUR = Topic("/robotskin/behaviour", "std_msgs/msg/String")
REFUSED = Topic("/robotskin/refused", "std_msgs/msg/String")
POLL_S = 0.02
PER_POLL = 10
"""Messages taken at once: a flood does not keep the others waiting."""


class Commanded(Protocol):
    """What may be asked of a session, from any thread."""

    def set_goal(self, goal: Floats) -> None:
        """Go there: (n,) rad or m of the joints. Raises a RobotskinError."""

    def set_behaviour(self, behaviour: str) -> None:
        """Do something else. Raises a RobotskinError."""


class Ros2Commands:
    """Hands what is heard on `GOAL` and `BEHAVIOUR` to a session until `close`; why something was refused is told on
    `REFUSED` and counted."""

    def __init__(self, node: DdsNode, joint_names: Sequence[str], session: Commanded) -> None:
        self.taken = self.refused = 0
        self._joints = list(joint_names)
        self._session = session
        self._goals, self._behaviours = node.reader(GOAL), node.reader(BEHAVIOUR)
        self._answers = node.writer(REFUSED)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="commands of ROS 2", daemon=True)
        self._thread.start()

    @property
    def talkers(self) -> tuple[int, int]:
        """How many may send goals, and behaviours."""
        return len(self._goals.get_matched_publications()), len(self._behaviours.get_matched_publications())

    def __enter__(self) -> Ros2Commands:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Hear no more."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.wait(POLL_S):
            for message in self._goals.take(N=PER_POLL):
                self._heed(self._take_goal, message)
            for message in self._behaviours.take(N=PER_POLL):
                self._heed(self._take_behaviour, message)

    def _take_goal(self, message: Any) -> None:
        self._session.set_goal(self._goal_of(message))

    def _take_behaviour(self, message: Any) -> None:
        self._session.set_behaviour(str(message.data))

    def _heed(self, take: Callable[[Any], None], message: Any) -> None:
        try:
            take(message)
            self.taken += 1
        except RobotskinError as error:
            self.refused += 1
            self._answers.send(cdr(REFUSED, short_names().String(data=str(error))))

    def _goal_of(self, message: Any) -> Floats:
        """(n,) in the order of the robot's joints. Raises InputError unless each is named once with a finite place."""
        names, places = list(message.name), list(message.position)
        if sorted(names) != sorted(self._joints) or len(places) != len(names):
            raise InputError(
                f"{GOAL.name}: {len(names)} names and {len(places)} positions: each of {', '.join(self._joints)} once"
            )
        goal = np.array([places[names.index(name)] for name in self._joints], dtype=float)
        if not np.isfinite(goal).all():
            raise InputError(f"{GOAL.name}: a position is no finite number")
        return goal
