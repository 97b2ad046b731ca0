# SPDX-License-Identifier: Apache-2.0
"""Command interfaces by limb: a hand may take torques on an arm that takes velocities."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from robotskin.choices import member
from robotskin.errors import InputError, UnknownNameError
from robotskin.model import CommandMode, RobotModel
from robotskin.robots.limbs import limbs_of

ByLimb = Mapping[str, CommandMode | str]


def modes_by_joint(robot: RobotModel, by_limb: ByLimb) -> list[CommandMode]:
    """(n) the interface of each joint.

    Args:
        robot: n joints.
        by_limb: interfaces of its limbs (`limbs_of`) and joints, by name; a joint's own wins over its limb's.

    Raises:
        UnknownNameError: a name that is neither, or no such interface. InputError: a joint without any.
    """
    limbs = {limb.name: limb.joints for limb in limbs_of(robot)}
    names = list(robot.joint_names)
    for name in by_limb:
        if name not in limbs and name not in names:
            raise UnknownNameError("limb or joint", name, [*limbs, *names])
    found: dict[str, CommandMode] = {}
    for name in sorted(by_limb, key=lambda one: one in names):  # limbs first: a joint's own wins
        mode = member("interface", CommandMode, by_limb[name])
        found |= dict.fromkeys([name] if name in names else limbs[name], mode)
    left = [name for name in names if name not in found]
    if left:
        raise InputError(f"interface by limb: none for {', '.join(left)}; limbs are {', '.join(limbs)}")
    return [found[name] for name in names]


def told(robot: RobotModel, modes: Sequence[CommandMode]) -> str:
    """In words, such as `carriage by velocity, others by torque`."""
    by_joint = dict(zip(robot.joint_names, modes, strict=True))
    most = Counter(reversed(modes)).most_common(1)[0][0]
    parts = []
    for limb in limbs_of(robot):
        its = [by_joint[joint] for joint in limb.joints]
        named = [(limb.name, its[0])] if len(set(its)) == 1 else zip(limb.joints, its, strict=True)
        parts += [f"{name} by {mode.name}" for name, mode in named if mode is not most]
    return ", ".join([*parts, f"others by {most.name}"] if parts else [str(most.name)])
