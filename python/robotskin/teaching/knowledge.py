# SPDX-License-Identifier: Apache-2.0
"""The file of what is known beforehand: classes with usual properties, activities, and the skills of robots."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path

import msgspec

from robotskin.errors import UnknownNameError
from robotskin.teaching.gripper import TeachingError
from robotskin.teaching.text_file import text_of


class ClassOf(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A class of things or places. properties: the usual ones of its members, SI units by their names."""

    is_a: str = ""
    properties: dict[str, float] = {}


class Activity(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Something that is done."""

    meaning: str


class RobotSkills(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The activities that a robot can carry out."""

    skills: tuple[str, ...]


class Knowledge(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Classes, activities and robots by name."""

    classes: dict[str, ClassOf]
    activities: dict[str, Activity]
    robots: dict[str, RobotSkills]

    def require_whole(self) -> None:
        """Raise UnknownNameError for a class or a skill that is named and not there, TeachingError for a property that
        is not a finite number above 0."""
        for name, one in self.classes.items():
            for quantity, value in one.properties.items():
                if not 0 < value < math.inf:
                    raise TeachingError(f"[classes.{name}]: {quantity} = {value}: must be finite and above 0")
            if one.is_a and one.is_a not in self.classes:
                raise UnknownNameError("class of the knowledge file", one.is_a, self.classes)
        for robot in self.robots.values():
            for skill in robot.skills:
                if skill not in self.activities:
                    raise UnknownNameError("activity of the knowledge file", skill, self.activities)

    def is_a(self, name: str, other: str) -> bool:
        """Whether a class is another one or a part of it. Raises UnknownNameError."""
        seen: set[str] = set()
        while name and name not in seen:
            if name == other:
                return True
            seen.add(name)
            name = self._class(name).is_a
        return False

    def require_a(self, name: str, other: str) -> None:
        """Raise UnknownNameError, which names those that there are, for a class that is no part of another one."""
        if name not in self.classes or name == other or not self.is_a(name, other):
            kinds = [one for one in self.classes if one != other and self.is_a(one, other)]
            raise UnknownNameError(f"{other} of the knowledge file", name, kinds)

    def usual(self, name: str, quantity: str) -> float:
        """The usual property of a class, its own or that of what it is a part of. Raises TeachingError if unknown."""
        asked, seen = name, set[str]()
        while name and name not in seen:
            seen.add(name)
            found = self._class(name)
            if quantity in found.properties:
                return found.properties[quantity]
            name = found.is_a
        raise TeachingError(f"{quantity} of {asked}: the knowledge file does not say; add it to [classes.{asked}]")

    def require_skills(self, robot: str, activities: list[str]) -> None:
        """Raise TeachingError, naming the step, if a robot cannot do one of these. UnknownNameError for the robot."""
        if robot not in self.robots:
            raise UnknownNameError("robot with skills", robot, self.robots)
        for activity in activities:
            if activity not in self.activities:
                raise UnknownNameError("activity of the plan", activity, self.activities)
            if activity not in self.robots[robot].skills:
                can = [name for name, one in self.robots.items() if activity in one.skills]
                raise TeachingError(f"step {activity!r}: {robot} cannot do it; {', '.join(can) or 'no robot'} can")

    def _class(self, name: str) -> ClassOf:
        if name not in self.classes:
            raise UnknownNameError("class of things", name, self.classes)
        return self.classes[name]


def load_knowledge(file: Path | None = None) -> Knowledge:
    """Read a knowledge file, by default the one that comes with the project.

    Raises TeachingError, naming field and value, for what does not fit; UnknownNameError for names that are not there.
    """
    if file is None:
        text = resources.files("robotskin.teaching").joinpath("knowledge.toml").read_text()
    else:
        text = text_of("knowledge file", file)
    try:
        found = msgspec.toml.decode(text, type=Knowledge)
    except (msgspec.DecodeError, ValueError) as error:
        raise TeachingError(f"knowledge file {file or 'of the project'}: {error}") from None
    found.require_whole()
    return found
