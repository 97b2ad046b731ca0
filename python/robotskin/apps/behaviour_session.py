"""A session whose controller runs behaviours by name."""

from __future__ import annotations

from typing import Any

from robotskin._core.model import RobotModel
from robotskin._core.skin import SkinModel
from robotskin.apps.session import Session
from robotskin.control import Behaviour, Controller
from robotskin.layout import Layout
from robotskin.robots import Robot


class BehaviourSession(Session):
    """A skinned robot that does what behaviours and goals say; see `Session` for the other arguments.

    Args:
        robot: the robot, which must have a gain file that names a gain set for the behaviour.
        layout: its skin.
        behaviour: to begin with, by name or made by hand.
        seed: repeats the run.
    """

    controller: Controller

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        behaviour: str | Behaviour = "skin_compliance",
        seed: int = 1,
        **options: Any,
    ) -> None:
        self._start = behaviour
        super().__init__(robot, layout, seed, **options)

    def make_cycle(self, robot: RobotModel, skin: SkinModel) -> Controller:
        """The controller of all behaviours."""
        self.controller = Controller(robot, skin, self.gains, self._start)
        return self.controller
