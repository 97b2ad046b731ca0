# SPDX-License-Identifier: Apache-2.0
"""The arm behind a UR controller, in MuJoCo: joint servos, and the motions that URScript asks of them."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from robotskin.model import RobotDynamics
from robotskin.robots import Robot
from robotskin.simulator import Imperfections

Floats = NDArray[np.float64]
PHYSICS_S = 0.001
STIFFNESS, DAMPING = 16_000.0, 220.0
"""1/s² and 1/s of the joint servos, scaled by the arm's inertia: as stiff as those of the simulated world."""
REST_RAD_S = 1e-4


class UrArm:
    """n joints that hold still, follow (`servo`, `speed`), stop, or take torques; `step` lets time pass.

    Args:
        robot: what it is.
        posture: (n) rad where it starts.
        friction: Coulomb friction as a share of each joint's effort limit; by default that of the simulated world.
    """

    def __init__(self, robot: Robot, posture: ArrayLike, friction: float | None = None) -> None:
        spec = robot.mujoco_spec()
        spec.option.timestep = PHYSICS_S
        self.model = spec.compile()
        share = Imperfections().joint_friction if friction is None else friction
        stated = robot.stated_friction
        self.model.dof_frictionloss[:] = [
            stated.get(name, share * limit) for name, limit in zip(robot.joint_names, robot.effort_limit, strict=True)
        ]
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = posture
        mujoco.mj_forward(self.model, self.data)
        self._dynamics = RobotDynamics(robot.core)
        self._effort_limit = robot.effort_limit
        self.target = np.array(posture, dtype=float)
        """(n) rad that the servos hold."""
        self.target_velocity = np.zeros(robot.joint_count)
        self.moment = np.zeros(robot.joint_count)
        """(n) Nm of the motors."""
        self._asked_torque: Floats | None = None
        self._asked: tuple[str, Floats, float] = ("hold", self.target.copy(), 0.0)
        self.speed_fraction = 1.0
        """Of the speed slider, for all motions but those by torque."""
        self.carries_weight = True
        """Whether the arm's weight is added to torques that are asked for."""

    @property
    def position(self) -> Floats:
        """(n) rad."""
        return self.data.qpos.copy()

    @property
    def velocity(self) -> Floats:
        """(n) rad/s."""
        return self.data.qvel.copy()

    @property
    def at_rest(self) -> bool:
        """Whether a stop has ended."""
        return self._asked_torque is None and bool((np.abs(self.target_velocity) < REST_RAD_S).all())

    def place(self, posture: Floats) -> None:
        """Put it elsewhere, (n) rad, at rest: what a person does with the pendant while no script runs."""
        self.data.qpos[:], self.data.qvel[:] = posture, 0.0
        mujoco.mj_forward(self.model, self.data)
        self.target, self.target_velocity = self.position, np.zeros(len(posture))
        self._asked_torque, self._asked = None, ("hold", self.target.copy(), 0.0)

    # ---- What is asked of it; holds until something else is ----

    def servo(self, position: Floats, lookahead_s: float) -> None:
        """Go there, smoothed over `lookahead_s`."""
        self._leave_torque()
        self._asked = ("servo", position, lookahead_s)

    def speed(self, velocity: Floats, acceleration: float) -> None:
        """Go on with rad/s, reached with rad/s²."""
        self._leave_torque()
        self._asked = ("speed", velocity, acceleration)

    def stop(self, deceleration: float) -> None:
        """Come to rest with rad/s², and hold."""
        self.speed(np.zeros(len(self.target)), deceleration)

    def torque(self, torque: Floats) -> None:
        """Nm; beside what carries the arm, if `carries_weight`."""
        self._asked_torque = torque

    def _leave_torque(self) -> None:
        if self._asked_torque is not None:
            self._asked_torque = None
            self.target, self.target_velocity = self.position, self.velocity

    # ---- Time ----

    def step(self, seconds: float) -> None:
        """Let a time pass, in whole milliseconds."""
        for _ in range(round(seconds / PHYSICS_S)):
            self._physics()

    def _physics(self) -> None:
        mujoco.mj_step1(self.model, self.data)
        if self._asked_torque is not None:
            torque = self._asked_torque
            if self.carries_weight:
                self._dynamics.update(self.position, np.zeros(len(self.target)))
                torque = torque + self._dynamics.gravity_torque
        else:
            self._lead()
            error = STIFFNESS * (self.target - self.data.qpos)
            error += DAMPING * (self.target_velocity * self.speed_fraction - self.data.qvel)
            torque = np.empty_like(error)
            mujoco.mj_mulM(self.model, self.data, torque, error)
            torque += self.data.qfrc_bias
        self.moment = np.clip(torque, -self._effort_limit, self._effort_limit)
        self.data.qfrc_applied[:] = self.moment
        mujoco.mj_step2(self.model, self.data)

    def _lead(self) -> None:
        kind, value, number = self._asked
        if kind == "servo":
            share = 1.0 - math.exp(-PHYSICS_S / max(number, PHYSICS_S))
            self.target_velocity = (value - self.target) * share / PHYSICS_S
        elif kind == "speed":
            most = number * PHYSICS_S
            self.target_velocity = self.target_velocity + np.clip(value - self.target_velocity, -most, most)
        else:
            self.target_velocity = np.zeros_like(self.target)
        self.target = self.target + self.target_velocity * self.speed_fraction * PHYSICS_S
