# SPDX-License-Identifier: Apache-2.0
"""Makes tasks by name, with the gains that the robot's file states for a behaviour."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robotskin.control.map_reaction import map_skin_task
from robotskin.control.self_collision import self_collision_task
from robotskin.errors import InputError, UnknownNameError
from robotskin.model import BASE, RobotModel
from robotskin.robots import Robot
from robotskin.robots.gains import ChosenGains
from robotskin.robots.limbs import limbs_of
from robotskin.robots.standing import feet_of
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.skin import SkinModel
from robotskin.tasks import (
    BalanceGains,
    BalanceTask,
    CartesianTask,
    ContactImpedanceTask,
    FootContactGains,
    FootContactTask,
    ForceGains,
    ForceTask,
    GravityTask,
    JointImpedanceTask,
    JointLimitTask,
    JointTask,
    Limb,
    MapSkinTask,
    PropagatedComplianceTask,
    PropagationGains,
    SelfCollisionTask,
    SkinCartesianTask,
    SkinGains,
    SkinReactionTask,
    SplineCartesianTask,
    SplineJointTask,
    Task,
    TouchMatrix,
    TouchWrench,
)

Maker = Callable[["TaskLibrary", ChosenGains], Task]


class TaskLibrary:
    """Tasks for one robot and its skin. What a user adds under a name of their own can be part of a behaviour.

    Args:
        robot: n joints.
        skin: N cells.
        body: the robot's surfaces, for the task "self_collision".
        skin_map: what the skin has learnt of itself, for the task "map_skin".

    Raises:
        InputError: a map of other joints, or of none of the skin's cells.
    """

    def __init__(
        self,
        robot: RobotModel,
        skin: SkinModel,
        body: Robot | None = None,
        skin_map: SensoryMotorMap | None = None,
    ) -> None:
        self.robot, self.skin, self.body = robot, skin, body
        self.feet = feet_of(robot)
        """Of a robot that stands."""
        self.balance_gains, self.foot_gains = BalanceGains(), FootContactGains()
        self.skin_map = skin_map
        self._makers: dict[str, Maker] = dict(_MAKERS)
        self._self_collision: SelfCollisionTask | None = None
        self._matrix = TouchMatrix(robot, skin)
        self._touches: dict[bytes, TouchWrench] = {}
        if skin_map is not None:
            _require_fit(skin_map, robot, skin)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all tasks that can be made."""
        return tuple(self._makers)

    def add(self, name: str, make: Maker) -> None:
        """Add a task: `make(library, gains)` returns it, a task of the core's or a `PythonTask`."""
        self._makers[name] = make

    def make(self, name: str, gains: ChosenGains) -> Task:
        """A new task, of what stands before the @ in its name.

        Raises UnknownNameError, and ModelError or ControlError for gains that do not fit the robot.
        """
        kind = name.partition("@")[0]
        if kind not in self._makers:
            raise UnknownNameError("task", kind, self._makers)
        return self._makers[kind](self, gains)

    def map_reaction(
        self, gains: ChosenGains, compliance_share: float = 1.0, silent: NDArray[np.bool_] | None = None
    ) -> MapSkinTask:
        """A reaction to touch by the map; `silent`: (N,) cells whose nearness is silent. See `map_skin_task`.

        Raises InputError where there is no map.
        """
        if self.skin_map is None:
            raise InputError(
                "task map_skin: there is no sensory-motor map: give skin_map (`robotskin configure --map FILE`)"
            )
        return map_skin_task(self.robot, self.skin, self.skin_map, gains, compliance_share, silent)

    def touch(self, gains: SkinGains) -> TouchWrench:
        """The touch with these gains, one for all tasks that ask for the same: it is computed once a tick."""
        thresholds = (gains.force_silent, gains.force_full, gains.proximity_silent, gains.proximity_full)
        arrays = (gains.force_weight, gains.proximity_weight, *thresholds)
        key = np.array(arrays, dtype=np.float32).tobytes()
        if key not in self._touches:
            self._touches[key] = TouchWrench(self._matrix, gains)
        return self._touches[key]


def _skin_filter_hz(gains: ChosenGains) -> float:
    return float(gains.gains.values["skin"]["bandwidth_hz"])


def _map_skin(own: TaskLibrary, gains: ChosenGains) -> Task:
    return own.map_reaction(gains)


def _require_fit(skin_map: SensoryMotorMap, robot: RobotModel, skin: SkinModel) -> None:
    if tuple(skin_map.joint_names) != tuple(robot.joint_names):
        raise InputError(
            f"sensory-motor map of {skin_map.robot}: its joints are {', '.join(skin_map.joint_names)}, the robot's "
            f"{', '.join(robot.joint_names)}"
        )
    if not np.isin(skin_map.cell, skin.key.astype(np.int64)).any():
        raise InputError(f"sensory-motor map of {skin_map.robot}: it knows none of the skin's {len(skin)} cells")


FORCE_INTEGRAL_PER_S = 0.1
"""Slow, so that soft walls do not swing: the force felt answers what is asked anyway, less what friction holds back."""


def _force(own: TaskLibrary, gains: ChosenGains) -> Task:
    """Refused where no cell can feel how the link presses: it would press ever harder."""
    robot = own.robot
    joint = robot.link_joints[robot.link_index(gains.link)]
    felt = []
    for name in sorted({own.skin.link_names[link] for link in own.skin.link}):
        above = robot.link_joints[robot.link_index(name)]
        while above not in (joint, BASE):
            above = robot.joint_parents[above]
        if above == joint:
            chosen = ForceGains()
            chosen.integral = FORCE_INTEGRAL_PER_S
            felt_force = own.touch(gains.skin(robot, own.skin).measured_force())
            return ForceTask(robot, felt_force, gains.link, chosen)
        felt.append(name)
    raise InputError(
        f"task force: no cell on or beyond {gains.link} feels how it presses; there are cells on {', '.join(felt)}"
    )


def _self_collision(own: TaskLibrary, gains: ChosenGains) -> Task:
    """One for all behaviours: which pairs are always near is looked up once, in the home posture."""
    if own._self_collision is None:
        if own.body is None:
            raise InputError("task self_collision: the robot's surfaces are not known: give body, a robots.Robot")
        own._self_collision = self_collision_task(own.body, gains.gains.home, gains.gains.self_collision_gains())
    return own._self_collision


def _standing(own: TaskLibrary, name: str) -> None:
    if not own.feet:
        raise InputError(f"task {name}: robot {own.robot.name} is mounted and has no feet that it stands on")


def _foot_contact(own: TaskLibrary, gains: ChosenGains) -> Task:
    _standing(own, "foot_contact")
    return FootContactTask(own.robot, own.feet, own.foot_gains)


def _balance(own: TaskLibrary, gains: ChosenGains) -> Task:
    _standing(own, "balance")
    return BalanceTask(own.robot, own.balance_gains)


def propagated_compliance(
    own: TaskLibrary, gains: ChosenGains, limbs: list[Limb] | None = None, chosen: PropagationGains | None = None
) -> PropagatedComplianceTask:
    """The task "propagated_compliance", with limbs and gains other than the usual ones where they are given.

    The touch is in newton, as [Cheng19 eq. 26] has it; nearness at full scale is a push of `proximity_n`.
    """
    newton = gains.gains.skin_gains_of(np.zeros(len(own.skin)))
    newton.force_weight = [1.0] * len(own.skin)
    limbs = limbs_of(own.robot) if limbs is None else limbs
    return PropagatedComplianceTask(own.robot, own.skin, own.touch(newton), limbs, chosen or PropagationGains())


_MAKERS: dict[str, Maker] = {
    "foot_contact": _foot_contact,
    "balance": _balance,
    "gravity": lambda own, gains: GravityTask(own.robot.joint_count),
    "joint": lambda own, gains: JointTask(own.robot, gains.joint),
    "spline_joint": lambda own, gains: SplineJointTask(own.robot, gains.joint, gains.speed_rad_s),
    "cartesian": lambda own, gains: CartesianTask(own.robot, gains.link, gains.cartesian),
    "spline_cartesian": lambda own, gains: SplineCartesianTask(
        own.robot, gains.link, gains.cartesian, gains.speed_m_s, gains.turn_speed_rad_s
    ),
    "skin": lambda own, gains: SkinReactionTask(
        own.touch(gains.skin(own.robot, own.skin)),
        _skin_filter_hz(gains),
        own_scale=gains.share["skin"],
    ),
    "map_skin": _map_skin,
    "skin_cartesian": lambda own, gains: SkinCartesianTask(
        own.robot, own.touch(gains.hand_skin(own.robot, own.skin)), gains.link, _skin_filter_hz(gains)
    ),
    "force": _force,
    "contact_impedance": lambda own, gains: ContactImpedanceTask(own.touch(gains.skin(own.robot, own.skin))),
    "propagated_compliance": propagated_compliance,
    "self_collision": _self_collision,
    "joint_limits": lambda own, gains: JointLimitTask(own.robot),
    "joint_impedance": lambda own, gains: JointImpedanceTask(own.robot, gains.joint),
    "posture": lambda own, gains: JointTask(own.robot, gains.joint, "posture"),
}

TASKS = tuple(_MAKERS)
"""Names of the library's tasks. "map_skin" needs a map, "self_collision" the robot's surfaces, "foot_contact" and
"balance" a robot that stands."""
