# SPDX-License-Identifier: Apache-2.0
"""A robot that explores its skin on its feet: arms, torso and head babble, and its legs keep it upright meanwhile."""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin import robots
from robotskin.configuring.exploration import Exploration, ExplorationError, Progress, unplaced
from robotskin.control import Controller
from robotskin.cycle import SafetyState
from robotskin.layout import Layout
from robotskin.loop import SkinLoop
from robotskin.model import CommandMode, JointCommand, PortStatus, RobotPort
from robotskin.ports import WrappedPort
from robotskin.robots import Robot
from robotskin.robots.free_space import FreeSpace
from robotskin.robots.gains import gains_of
from robotskin.robots.standing import BASE_JOINTS
from robotskin.selfconfig.babbling.joint_sine import JointSine, MotionLimits
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
    """Postures that touch nothing, ask little of the joints, and leave the centre of mass above the feet.

    Args:
        robot: as it is mounted.
        home: (n) from which all other joints stay.
        joints: that move.
        reach_m: of the centre of mass, from where it is at home.
    """

    def __init__(self, robot: Robot, home: Array, joints: list[int], reach_m: float = REACH_M) -> None:
        super().__init__(robot, home=home)
        hold_others(self, home, joints)
        self._reach_m, self._middle, self._joints = reach_m, self._centre(home), np.array(joints)
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
        if trouble is not None:
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


def hold_others(space: FreeSpace, home: Array, joints: list[int]) -> FreeSpace:
    """The same space, in which all but these joints stay at home (n)."""
    held = np.setdiff1d(np.arange(space.robot.joint_count), joints)
    space.lower[held] = space.upper[held] = home[held]
    return space


class _Legs(WrappedPort):
    """The robot's port as balance sees it: it measures, and what it is told waits for what the other joints do."""

    def __init__(self, port: RobotPort) -> None:
        super().__init__(port)
        self.told: Array | None = None
        """(n) rad or m of the last tick that told any; None before."""

    def write(self, command: JointCommand) -> PortStatus:
        self.told = np.array(command.value)
        return PortStatus.ok

    def stop(self) -> None:
        """Legs stay as they were told last."""


class StandingExploration(Exploration):
    """A robot on its feet, ready to babble with what its legs do not carry by.

    Its base is estimated. What the skin feels moves nothing.

    Args:
        robot: that stands.
        layout: of the simulated world, which nothing here looks at.
        seed: of the world.
    """

    travel_speed, travel_acceleration = 0.6, 1.5
    others_move = True

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
        if self._wanted and self._loop.guard.state is SafetyState.stopped:
            raise ExplorationError(f"balance stopped: {self._loop.guard.text}")

    def _asked(self, posture: Array) -> Array:
        asked = posture.copy() if self._legs.told is None else self._legs.told
        asked[self._babbles] = posture[self._babbles]
        return asked


def leg_joints(robot: Robot) -> list[int]:
    """Of a robot that stands: the joints between its base and its feet."""
    assert robot.standing is not None
    carriers = [robot.model.frames[robot.model.getFrameId(foot.link)].parentJoint for foot in robot.standing.feet]
    found = {joint - 1 for carrier in carriers for joint in robot.model.supports[carrier]}
    return sorted(joint for joint in found if joint >= len(BASE_JOINTS))


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

    def planned(space: FreeSpace, at: Array, joints: list[int], limits: MotionLimits) -> BabblingPlan:
        return plan_babbling(
            space,
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
    hanging_space = hold_others(FreeSpace(hanging, home=hung), hung, legs)
    hanging_plan = planned(hanging_space, hung, legs, MotionLimits())
    standing_space = BalancedSpace(hanging, home[base:], others)
    standing_plan = _on_feet(planned(standing_space, home[base:], others, LIMITS), home[:base])
    tell("hanging: waking the skin", 0.0)
    hangs = Exploration(hanging, dataclasses.replace(layout, robot=hanging.name), seed, hung)
    felt_hanging = carried_out(hangs, hanging_plan, "hanging")
    tell("standing: waking the skin", 0.0)
    felt_standing = carried_out(StandingExploration(robot, layout, seed), standing_plan, "standing")
    return joined([_hung_upright(felt_hanging, robot, home[:base]), felt_standing])


def _with_base(base: Array, postures: Array) -> Array:
    """(K, 6 + n) the six joints of the base (6) before those of a mounted robot (K, n)."""
    return np.hstack([np.tile(base, (len(postures), 1)), postures])


def _swing_with_base(base: Array, swing: JointSine) -> JointSine:
    return dataclasses.replace(swing, joint=swing.joint + len(base), centre=np.concatenate([base, swing.centre]))


def _on_feet(plan: BabblingPlan, base: Array) -> BabblingPlan:
    """The plan of a mounted robot, for the same robot with a base (6)."""
    rests = dataclasses.replace(
        plan.postures,
        postures=_with_base(base, plan.postures.postures),
        way=_with_base(base, plan.postures.way),
    )
    swings = tuple(tuple(_swing_with_base(base, one) for one in each) for each in plan.swings)
    return dataclasses.replace(plan, postures=rests, swings=swings)


def _hung_upright(recording: BabblingRecording, robot: Robot, base: Array) -> BabblingRecording:
    """What a robot recorded while it hung, as of the same robot with a base (6)."""
    swings = tuple(dataclasses.replace(one, swing=_swing_with_base(base, one.swing)) for one in recording.swings)
    return dataclasses.replace(
        recording,
        robot=robot.name,
        joint_names=robot.joint_names,
        rest_posture=_with_base(base, recording.rest_posture),
        swings=swings,
    )
