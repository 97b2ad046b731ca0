# SPDX-License-Identifier: Apache-2.0
"""The limbs of a robot, from its file: which joints belong together, and which limb carries which."""

from __future__ import annotations

import tomllib
from importlib import resources
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from robotskin.errors import RobotskinError, UnknownNameError
from robotskin.model import JointKind, RobotModel
from robotskin.tasks import Limb

FOLDER = "limbs"
TURN_RAD_S2, SLIDE_M_S2 = 15.0, 1.0
"""Largest accelerations of joints that turn and that slide, where a file states none."""


class LimbsError(RobotskinError):
    """A file of limbs that cannot be used; the message names file, limb, field, value and what would be valid."""


class LimbEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A limb in a file, whose section has the limb's name."""

    joints: Annotated[list[str], Meta(min_length=1)]
    parent: str = ""
    acceleration: list[Annotated[float, Meta(gt=0, lt=1e6)]] | None = None
    """(joints) rad/s² or m/s², the largest."""


def limbs_of(robot: RobotModel) -> list[Limb]:
    """The limbs of a robot, parents first: as the file of its name has them, else a limb for each branch.

    Raises what `read_limbs` raises.
    """
    file = resources.files("robotskin.robots").joinpath(FOLDER, f"{robot.name}.toml")
    if not file.is_file():
        return branches(robot)
    return read_limbs(file.read_text(encoding="utf-8"), f"{robot.name}.toml", robot)


def load_limbs(path: str | Path, robot: RobotModel) -> list[Limb]:
    """The limbs in a file. Raises FileNotFoundError and what `read_limbs` raises."""
    return read_limbs(Path(path).read_text(encoding="utf-8"), str(path), robot)


def read_limbs(text: str, source: str, robot: RobotModel) -> list[Limb]:
    """The limbs in a TOML text, parents first.

    Args:
        text: a section a limb.
        source: names the text in errors.
        robot: whose limbs they are.

    Raises:
        LimbsError: a text that cannot be used. UnknownNameError: a joint or a parent that there is none of.
    """
    try:
        entries = msgspec.convert(tomllib.loads(text), dict[str, LimbEntry])
    except tomllib.TOMLDecodeError as error:
        raise LimbsError(f"{source}: no TOML: {error}") from None
    except msgspec.ValidationError as error:
        raise LimbsError(f"{source}: {error}; a limb has {', '.join(LimbEntry.__struct_fields__)}") from None
    if not entries:
        raise LimbsError(f"{source}: it names no limb")
    for name, entry in entries.items():
        for joint in entry.joints:
            if joint not in robot.joint_names:
                raise UnknownNameError(f"joint of limb {name} in {source}", joint, robot.joint_names)
        if entry.parent and entry.parent not in entries:
            raise UnknownNameError(f"parent of limb {name} in {source}", entry.parent, entries)
        if entry.acceleration is not None and len(entry.acceleration) != len(entry.joints):
            raise LimbsError(
                f"{source}: limb {name} has {len(entry.joints)} joints and {len(entry.acceleration)} accelerations"
            )
    ordered: list[Limb] = []
    placed: set[str] = set()
    while len(ordered) < len(entries):
        ready = [
            name for name, entry in entries.items() if name not in placed and (entry.parent or name) in {*placed, name}
        ]
        if not ready:
            ring = ", ".join(name for name in entries if name not in placed)
            raise LimbsError(f"{source}: limbs {ring} carry each other in a ring: one of them must have no parent")
        for name in ready:
            entry = entries[name]
            placed.add(name)
            ordered.append(Limb(name, entry.joints, entry.parent, entry.acceleration or _usual(robot, entry.joints)))
    return ordered


def branches(robot: RobotModel) -> list[Limb]:
    """The limbs of a robot that no file describes: the joints from one branching to the next, named by the first."""
    names, parents = list(robot.joint_names), [int(parent) for parent in robot.joint_parents]
    children = {
        joint: [one for one, parent in enumerate(parents) if parent == joint] for joint in range(-1, len(names))
    }
    found: list[Limb] = []
    limb_of: dict[int, str] = {-1: ""}
    for joint in range(len(names)):  # parents come before their children
        parent = parents[joint]
        if parent >= 0 and len(children[parent]) == 1:
            limb_of[joint] = limb_of[parent]
            continue
        limb_of[joint] = names[joint]
        chain = [joint]
        while len(children[chain[-1]]) == 1:
            chain.append(children[chain[-1]][0])
        joints = [names[one] for one in chain]
        found.append(Limb(names[joint], joints, limb_of[parent], _usual(robot, joints)))
    return found


def _usual(robot: RobotModel, joints: list[str]) -> list[float]:
    kinds = dict(zip(robot.joint_names, robot.joint_kinds, strict=True))
    return [SLIDE_M_S2 if kinds[joint] == JointKind.prismatic else TURN_RAD_S2 for joint in joints]
