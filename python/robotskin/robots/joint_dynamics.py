# SPDX-License-Identifier: Apache-2.0
"""Dynamics of joints as files, in place of what a URDF says: damping, friction, effort, rotor inertia.

They are written into the robot's text before any model is built from it, so that MuJoCo, guard and core have the same.
For rotor inertia a URDF has no place: the core's model is told it, and the others take it from there.
"""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Annotated, NamedTuple
from xml.etree import ElementTree

import msgspec
from msgspec import Meta

from robotskin.errors import RobotskinError, UnknownNameError

FOLDER = "dynamics"
ALL, LIKE = "all", "like"


class JointDynamicsError(RobotskinError):
    """A file of dynamics that cannot be used; the message names file, joint, field, value and what would be valid."""


class JointDynamics(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What replaces a joint's own values; what is left out stays. For prismatic joints read N and m."""

    damping: Annotated[float, Meta(ge=0, lt=1e9)] | None = None
    """Nm s/rad."""
    friction: Annotated[float, Meta(ge=0, lt=1e9)] | None = None
    """Nm, Coulomb's."""
    effort: Annotated[float, Meta(gt=0, lt=1e9)] | None = None
    """Nm, the most that the joint gives."""
    rotor_inertia: Annotated[float, Meta(ge=0, lt=1e9)] | None = None
    """kg m², of the motor's rotor as the joint feels it through its gears; a URDF has no place for it."""


class StatedDynamics(NamedTuple):
    """What a file states and a URDF does not hold for every reader, by name of the joint."""

    friction: dict[str, float]
    """Nm or N."""
    rotor_inertia: dict[str, float]
    """kg m² or kg."""


def dynamics_file(robot: str) -> str | None:
    """The text of the file that comes with the project for a robot of this name, or None."""
    file = resources.files("robotskin.robots").joinpath(FOLDER, f"{robot}.toml")
    return file.read_text(encoding="utf-8") if file.is_file() else None


def apply_dynamics(root: ElementTree.Element, text: str, source: str) -> StatedDynamics:
    """Write the dynamics of a TOML text into a URDF, in place.

    Args:
        root: the `<robot>` element.
        text: `[all]` for every movable joint, and sections by name of a joint, which count before it. `like = "ROBOT"`
            before them: what is not here stands in that robot's file.
        source: names the text in errors.

    Returns:
        The friction and the rotor inertia that the text states.

    Raises:
        JointDynamicsError: a text that cannot be used. UnknownNameError: a joint that the robot does not have.
    """
    try:
        sections = _sections(tomllib.loads(text), source)
    except tomllib.TOMLDecodeError as error:
        raise JointDynamicsError(f"{source}: no TOML: {error}") from None
    except msgspec.ValidationError as error:
        fields = ", ".join(JointDynamics.__struct_fields__)
        raise JointDynamicsError(f"{source}: {error}; a joint has {fields}") from None
    movable = {joint.get("name", ""): joint for joint in root.findall("joint") if joint.get("type") != "fixed"}
    for name in sections:
        if name != ALL and name not in movable:
            raise UnknownNameError(f"movable joint of {source}", name, [*movable, ALL])
    usual = sections.get(ALL, JointDynamics())
    stated = StatedDynamics({}, {})
    for name, joint in movable.items():
        own = sections.get(name, JointDynamics())
        for field, tag in (("damping", "dynamics"), ("friction", "dynamics"), ("effort", "limit")):
            value = getattr(own, field) if getattr(own, field) is not None else getattr(usual, field)
            if value is None:
                continue
            element = joint.find(tag)
            if element is None:
                element = ElementTree.SubElement(joint, tag)
            element.set(field, repr(value))
            if field == "friction":
                stated.friction[name] = value
        rotor = own.rotor_inertia if own.rotor_inertia is not None else usual.rotor_inertia
        if rotor is not None and float(joint.find("limit").get("effort", "0")) > 0:  # type: ignore[union-attr]
            stated.rotor_inertia[name] = rotor
    return stated


def _sections(read: dict[str, object], source: str) -> dict[str, JointDynamics]:
    like = read.pop(LIKE, None)
    own = msgspec.convert(read, dict[str, JointDynamics])
    if like is None:
        return own
    part = dynamics_file(like) if isinstance(like, str) else None
    if part is None:
        raise JointDynamicsError(f"{source}: like = {like!r}: no file of dynamics comes with a robot of this name")
    return _sections(tomllib.loads(part), f"dynamics of {like}") | own
