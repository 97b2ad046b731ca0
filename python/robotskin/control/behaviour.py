# SPDX-License-Identifier: Apache-2.0
"""The behaviours of figure 11 and section V-E: which tasks each is made of, and how they are fused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from robotskin.errors import InputError, UnknownNameError
from robotskin.tasks import FEEDFORWARD, Fusion


@dataclass(frozen=True)
class Part:
    """What a task of a behaviour acts on where that is not the whole robot, and whose gains it takes."""

    gains: str
    """A behaviour whose gain set it takes."""
    joints: tuple[str, ...] = ()
    """Whose joints a joint task moves, and on whose links a skin task feels; none: all."""
    link: str = ""
    """Moved instead of the one that the gain file names."""


@dataclass(frozen=True)
class Behaviour:
    """A behaviour: names of tasks (`robotskin.control.TASKS`) with their levels, 0 the highest, and their fusion.

    Raises InputError for a fusion that is none.
    """

    name: str
    tasks: dict[str, int]
    fusion: Fusion
    meaning: str = "does as its tasks say"
    """In one sentence that begins with what the robot does, for people who choose."""
    gains: str = ""
    """The behaviour whose gain set it takes; its own name by default."""
    parts: Mapping[str, Part] = field(default_factory=dict)
    """By task, for those that act on a part of the robot. Tasks of one kind are told apart by `kind@part`."""

    def __post_init__(self) -> None:
        if not isinstance(self.fusion, Fusion):
            choices = ", ".join(f"Fusion.{one.name}" for one in Fusion)
            raise InputError(f"behaviour {self.name}: fusion {self.fusion!r}: choose from {choices}")

    def part(self, task: str) -> Part:
        """What a task acts on, and whose gains it takes; by default the whole robot, and the behaviour's own."""
        return self.parts.get(task, Part(self.gains or self.name))

    def with_fusion(self, fusion: Fusion) -> Behaviour:
        """The same tasks fused in another way."""
        return replace(self, fusion=fusion)

    def with_map(self) -> Behaviour:
        """The same, its reaction to touch recalled from a sensory-motor map, which needs no kinematic model (IV-A).

        Raises InputError where touch moves the hand, for which there is no map.
        """
        if "skin" not in self.tasks:
            fits = ", ".join(name for name, one in BEHAVIOURS.items() if "skin" in one.tasks)
            raise InputError(f"{self.name} by a sensory-motor map: only these have a map's form: {fits}")
        tasks = {("map_skin" if name == "skin" else name): level for name, level in self.tasks.items()}
        return replace(self, tasks=tasks)

    def protected(self) -> Behaviour:
        """The same, below tasks that keep joints from their limits and bodies from each other.

        Tasks beside each other [Cheng19 eq. 18] stay so, but leave the motions alone that those need
        [Cheng19 eq. 19, 20]: beside a stiff one that asks for a collision they would have too little weight.
        """
        tasks = {name: level + 1 if level >= 0 else level for name, level in self.tasks.items()}
        fusion = Fusion.null_space if self.fusion is Fusion.weighted_sum else self.fusion
        return replace(self, tasks={"joint_limits": 0, "self_collision": 0} | tasks, fusion=fusion)

    def standing(self) -> Behaviour:
        """The same on a robot that stands: below the tasks that hold its feet and its balance (V-D)."""
        above = {"foot_contact": 0, "balance": 1}
        tasks = {name: level + 2 if level >= 0 else level for name, level in self.tasks.items()}
        fusion = Fusion.null_space if self.fusion in (Fusion.weighted_sum, Fusion.null_space_at_rest) else self.fusion
        return replace(self, tasks=above | tasks, fusion=fusion)


def _paper(name: str, tasks: tuple[str, ...], meaning: str) -> Behaviour:
    """One row of figure 11: all tasks beside each other [Cheng19 eq. 18], with gravity."""
    return Behaviour(name, {**dict.fromkeys(tasks, 0), "gravity": FEEDFORWARD}, Fusion.weighted_sum, meaning)


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
        Behaviour(
            "propagated_compliance",
            {"propagated_compliance": 0, "gravity": FEEDFORWARD},
            Fusion.weighted_sum,
            "gives way with all its limbs: what an arm cannot give, the base gives",
            gains="skin_compliance",
        ),
    )
}
"""By name: the six of figure 11, and that of section V-E."""

PRESS = Behaviour(
    "press",
    {"force": 0, "posture": 1, "gravity": FEEDFORWARD},
    Fusion.null_space,
    "presses with a force that its skin measures",
    gains="reach_cartesian_compliant",
)
"""What a goal that states a force chooses; figure 11 has no such behaviour."""


def behaviour(name: str) -> Behaviour:
    """The behaviour of this name. Raises UnknownNameError with the choices."""
    if name not in BEHAVIOURS:
        raise UnknownNameError("behaviour", name, BEHAVIOURS)
    return BEHAVIOURS[name]
