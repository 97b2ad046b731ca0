# SPDX-License-Identifier: Apache-2.0
"""A robot whose goal lies inside of itself keeps its bodies apart, through whatever interface it is moved."""

import numpy as np
import pytest

from robotskin import robots
from robotskin.control import JointGoal
from robotskin.control.self_collision import self_collision_task
from robotskin.model import RobotDynamics
from robotskin.robots.gains import GainSet
from robotskin.skin import SkinState
from robotskin_lab.bench.control_rig import ControlRig

SETTLE_S = {"talos": 5.0, "dual_arm": 12.0, "allegro_right_hand": 15.0}


class Meter:
    """How near the bodies of a robot come to each other, by its own task."""

    def __init__(self, name: str) -> None:
        self.core = robots.load(name).core
        self.task = self_collision_task(robots.load(name), GainSet.load(name).home)
        self.dynamics = RobotDynamics(self.core)
        self.zero = np.zeros(self.core.joint_count)

    def distance_m(self, posture: np.ndarray) -> float:
        self.dynamics.update(posture, self.zero)
        self.task.update(self.dynamics, self.zero, self.zero, SkinState(0), np.zeros(0, dtype=np.float32))
        return min((pair.distance_m for pair in self.task.near), default=np.inf)


def colliding_posture(name: str, meter: Meter, rng: np.random.Generator) -> np.ndarray:
    """A posture beside the home posture in which two bodies are more than 10 mm inside each other."""
    home, core = GainSet.load(name).home, meter.core
    lower, upper = np.maximum(core.lower, home - 1.2), np.minimum(core.upper, home + 1.2)
    for _ in range(10_000):
        moved = (rng.random(core.joint_count) < 0.4) & np.isfinite(core.lower)
        posture = np.where(moved, rng.uniform(lower, upper), home)
        if meter.distance_m(posture) < -0.01:
            return posture
    raise AssertionError("no posture collides")


@pytest.mark.parametrize(
    ("name", "interface"), [("talos", "position"), ("dual_arm", "velocity"), ("allegro_right_hand", "torque")]
)
def test_a_goal_inside_the_robot_is_not_reached(name: str, interface: str, seed: int) -> None:
    meter = Meter(name)
    goal = colliding_posture(name, meter, np.random.default_rng(seed))
    rig = ControlRig(name, "reach_joint_goal_compliant", interface, seed, hands=0, self_collision=True)
    rig.controller.go(JointGoal(goal))
    before = np.abs(rig.joints.position - goal).max()
    for _ in range(round(SETTLE_S[name] / 0.02)):
        rig.run(0.02)
        assert meter.distance_m(np.array(rig.joints.position)) > 0.005
    assert rig.running
    assert rig.controller.report.violations == 0
    assert np.abs(rig.joints.position - goal).max() < before, "it goes as far as it can"
