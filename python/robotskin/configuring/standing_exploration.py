# SPDX-License-Identifier: Apache-2.0
"""A robot that explores its skin on its feet: arms, torso and head babble, and its legs keep it upright meanwhile."""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin import robots
from robotskin.configuring.exploration import Exploration, Progress, unplaced
from robotskin.control import Controller
from robotskin.layout import Layout
from robotskin.loop import SkinLoop
from robotskin.model import CommandMode, JointCommand, JointState, PortStatus, RobotPort, SensorReadings
from robotskin.robots import Robot
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import gains_of
from robotskin.robots.standing import BASE_JOINTS
from robotskin.selfconfig.babbling.joint_sine import MotionLimits
from robotskin.selfconfig.babbling.plan import BabblingPlan, plan_babbling
from robotskin.selfconfig.readings.recording import BabblingRecording, joined
from robotskin.skin import DatagramInput

Array = NDArray[np.float64]

REACH_M = 0.05
"""How far a posture may take the centre of mass aside; the legs bring it back."""
BORNE_SHARE = 0.6
"""Of a joint's torque that a posture may ask for; the rest is for moving there."""
TRUNK_SHARE, TRUNK_RAD = 0.25, 0.15
"""A joint that carries more than this share of the mass turns no farther than that from home."""
LIMITS = MotionLimits(acceleration=4.0)
"""Of swings on feet: what swings pushes against the floor."""


class BalancedSpace(FreeSpace):
    """Postures that touch nothing, move these joints alone, ask little of them, and leave the centre of mass above the
    feet.

    Args:
        robot: as it is mounted.
        home: (n) from which all other joints stay.
        joints: that move.
        reach_m: of the centre of mass, from where it is at home; None: anywhere, and joints may bear what they can.
    """

    def __init__(self, robot: Robot, home: Array, joints: list[int], reach_m: float | None) -> None:
        super().__init__(robot, home=home)
        held = np.setdiff1d(np.arange(robot.joint_count), joints)
        self.lower[held] = self.upper[held] = home[held]
        self._reach_m, self._middle, self._joints = reach_m, self._centre(home), np.array(joints)
        if reach_m is not None:
            pinocchio.computeSubtreeMasses(robot.model, self._data)
            carried = np.array(self._data.mass[1:]) / self._data.mass[0]
            trunk = [joint for joint in joints if carried[joint] > TRUNK_SHARE]
            self.lower[trunk] = np.maximum(self.lower[trunk], home[trunk] - TRUNK_RAD)
            self.upper[trunk] = np.minimum(self.upper[trunk], home[trunk] + TRUNK_RAD)

    def _centre(self, q: Array) -> Array:
        return np.array(pinocchio.centerOfMass(self.robot.model, self._data, q)[:2])

    def why_not(self, q: Array) -> str | None:
        """As of any space; or how far the centre of mass would be aside, or what a joint would bear."""
        trouble = super().why_not(q)
        if trouble is not None or self._reach_m is None:
            return trouble
        q = np.asarray(q, dtype=float)
        aside_m = float(np.linalg.norm(self._centre(q) - self._middle))
        if aside_m > self._reach_m:
            return f"the centre of mass is {aside_m:.3f} m aside, allowed {self._reach_m} m"
        torque = pinocchio.computeGeneralizedGravity(self.robot.model, self._data, q)
        share = (np.abs(torque) / self.robot.effort_limit)[self._joints]
        hardest = int(np.argmax(share))
        if share[hardest] > BORNE_SHARE:
            name = self.robot.joint_names[self._joints[hardest]]
            return f"joint {name} bears {share[hardest]:.2f} of its torque, allowed {BORNE_SHARE}"
        return None


class _Legs(RobotPort):
    """The robot's port as balance sees it: it measures, and what it is told waits for what the other joints do."""

    def __init__(self, port: RobotPort) -> None:
        super().__init__(port.joint_count, [CommandMode.position], port.sensors)
        self._port = port
        self.told: Array | None = None
        """(n) rad or m of the last tick; None: balance has stopped."""

    def read(self, state: JointState) -> PortStatus:
        return self._port.read(state)

    def read_sensors(self, readings: SensorReadings) -> PortStatus:
        return self._port.read_sensors(readings)

    def write(self, command: JointCommand) -> PortStatus:
        self.told = np.array(command.value)
        return PortStatus.ok

    def stop(self) -> None:
        self.told = None


class StandingExploration(Exploration):
    """A robot on its feet, ready to babble with what its legs do not carry by.

    Its base is estimated. What the skin feels moves nothing.

    Args:
        robot: that stands.
        layout: of the simulated world, which nothing here looks at.
        seed: of the world.
    """

    travel_speed, travel_acceleration = 0.6, 1.5

    def __init__(self, robot: Robot, layout: Layout, seed: int = 1) -> None:
        legs = set(leg_joints(robot)) | set(range(len(BASE_JOINTS)))
        self._babbles = np.array([joint for joint in range(robot.joint_count) if joint not in legs])
        super().__init__(robot, layout, seed, gains_of(robot).home)

    def _start(self) -> None:
        gains, model = gains_of(self.robot), unplaced(self.keys, self.robot.base_link)
        self._controller = Controller(self.robot.core, model, gains)
        self._controller.request_skin(False)
        self._legs, self._input = _Legs(self.world.port), DatagramInput(self.reader)
        self._loop = SkinLoop(self._legs, self._input, self._controller.cycle)
        self._loop.request_mode(CommandMode.position)
        self._loop.request_run(True)
        super()._start()

    def _sense(self, now_ns: int) -> None:
        self._loop.step(now_ns)
        self.skin, self.joints = self._loop.skin, self._loop.joints

    def _asked(self, posture: Array) -> Array:
        if self._legs.told is None:
            return self.goal
        asked = self._legs.told.copy()
        asked[self._babbles] = posture[self._babbles]
        return asked


def leg_joints(robot: Robot) -> list[int]:
    """Of a robot that stands: the joints between its base and its feet."""
    assert robot.standing is not None
    found: set[int] = set()
    for foot in robot.standing.feet:
        joint = robot.model.frames[robot.model.getFrameId(foot.link)].parentJoint
        while joint > len(BASE_JOINTS):
            found.add(joint - 1)
            joint = robot.model.parents[joint]
    return sorted(found)


def babble_hanging_and_standing(
    robot: Robot,
    layout: Layout,
    seed: int,
    *,
    postures: int,
    swing_postures: int,
    progress: Progress | None = None,
) -> BabblingRecording:
    """Babble with the legs while the robot hangs by its pelvis, then with all else while it stands.

    Args:
        robot: that stands.
        layout: of the simulated world; nothing else looks at it.
        seed: of world and plans.
        postures: to rest in, each time; swing_postures: in how many of them every joint swings.
        swing_postures: see postures.
        progress: told what is done.

    Raises:
        BabblingError: nowhere to move. ExplorationError: a silent skin, or a stopped robot.
    """
    assert robot.standing is not None
    hanging, base = robots.load(robot.standing.mounted), len(BASE_JOINTS)
    legs = [joint - base for joint in leg_joints(robot)]
    others = [joint for joint in range(hanging.joint_count) if joint not in legs]
    home, hung = np.array(gains_of(robot).home), np.array(gains_of(hanging).home)
    random = np.random.default_rng(seed)
    tell = progress or (lambda _what, _share: None)

    def planned(at: Array, joints: list[int], reach_m: float | None, limits: MotionLimits) -> BabblingPlan:
        return plan_babbling(
            BalancedSpace(hanging, at, joints, reach_m),
            at,
            random,
            joints=joints,
            postures=postures,
            swing_postures=swing_postures,
            limits=limits,
        )

    def carried_out(exploration: Exploration, plan: BabblingPlan, how: str) -> BabblingRecording:
        try:
            return exploration.babble(plan, progress=lambda what, share: tell(f"{how}: {what}", share))
        finally:
            exploration.stop()

    tell("planning", 0.0)
    hanging_plan = planned(hung, legs, None, MotionLimits())
    standing_plan = _on_feet(planned(home[base:], others, REACH_M, LIMITS), home[:base])
    tell("hanging: waking the skin", 0.0)
    hangs = Exploration(hanging, dataclasses.replace(layout, robot=hanging.name), seed, hung)
    felt_hanging = carried_out(hangs, hanging_plan, "hanging")
    tell("standing: waking the skin", 0.0)
    felt_standing = carried_out(StandingExploration(robot, layout, seed), standing_plan, "standing")
    return joined([_with_base(felt_hanging, robot, home[:base]), felt_standing])


def _on_feet(plan: BabblingPlan, base: Array) -> BabblingPlan:
    """The plan of a mounted robot, for the same robot with the six joints of its base (6) before the others."""

    def with_base(postures: Array) -> Array:
        return np.hstack([np.tile(base, (len(postures), 1)), postures])

    rests = dataclasses.replace(
        plan.postures, postures=with_base(plan.postures.postures), way=with_base(plan.postures.way)
    )
    swings = tuple(
        tuple(
            dataclasses.replace(one, joint=one.joint + len(base), centre=np.concatenate([base, one.centre]))
            for one in each
        )
        for each in plan.swings
    )
    return BabblingPlan(rests, swings, plan.blocked)


def _with_base(recording: BabblingRecording, robot: Robot, base: Array) -> BabblingRecording:
    """What a robot recorded while it hung upright, as of the robot that stands."""
    count = len(base)
    swings = tuple(
        dataclasses.replace(
            one,
            swing=dataclasses.replace(
                one.swing, joint=one.swing.joint + count, centre=np.concatenate([base, one.swing.centre])
            ),
        )
        for one in recording.swings
    )
    postures = np.hstack([np.tile(base, (len(recording.rest_posture), 1)), recording.rest_posture])
    return dataclasses.replace(
        recording, robot=robot.name, joint_names=robot.joint_names, rest_posture=postures, swings=swings
    )
