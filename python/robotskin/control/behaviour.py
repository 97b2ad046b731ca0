"""The behaviours of figure 11: which tasks each is made of, and how they are fused."""

from __future__ import annotations

from dataclasses import dataclass

from robotskin._core.control import UNPROJECTED, Fusion
from robotskin.errors import UnknownNameError


@dataclass(frozen=True)
class Behaviour:
    """A behaviour: names of tasks (`robotskin.control.TASKS`) with their levels, 0 the highest, and their fusion."""

    name: str
    tasks: dict[str, int]
    fusion: Fusion
    meaning: str
    """In one sentence, for people who choose."""

    def with_fusion(self, fusion: Fusion) -> Behaviour:
        """The same tasks fused in another way."""
        return Behaviour(self.name, self.tasks, fusion, self.meaning)


def _paper(name: str, tasks: tuple[str, ...], meaning: str) -> Behaviour:
    """One row of figure 11: all tasks beside each other (eq. 18), with gravity."""
    return Behaviour(name, {**dict.fromkeys(tasks, 0), "gravity": UNPROJECTED}, Fusion.weighted_sum, meaning)


BEHAVIOURS = {
    one.name: one
    for one in (
        _paper("skin_compliance", ("joint", "skin"), "holds a posture and gives way to touch"),
        _paper("reach_joint_goal_compliant", ("spline_joint", "skin"), "moves to a posture and gives way to touch"),
        _paper("reach_cartesian_compliant", ("cartesian", "skin"), "holds its hand's pose and gives way to touch"),
        _paper(
            "reach_cartesian_goal_compliant",
            ("spline_cartesian", "skin_cartesian"),
            "moves its hand to a pose; a touch moves the hand aside",
        ),
        _paper("kinesthetic_joint", ("skin",), "goes where it is pushed, and stays there"),
        _paper(
            "kinesthetic_cartesian", ("skin_cartesian",), "its hand goes where the robot is pushed, and stays there"
        ),
    )
}
"""By name."""


def behaviour(name: str) -> Behaviour:
    """The behaviour of this name. Raises UnknownNameError with the choices."""
    if name not in BEHAVIOURS:
        raise UnknownNameError("behaviour", name, BEHAVIOURS)
    return BEHAVIOURS[name]
