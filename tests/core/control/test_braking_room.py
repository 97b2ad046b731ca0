# SPDX-License-Identifier: Apache-2.0
"""Where limits seem to exclude each other: what is found does not depend on how many steps a tick has."""

import numpy as np
import pytest
from numpy.typing import NDArray

from robotskin import robots
from robotskin.model import RobotDynamics
from robotskin.tasks import QuadraticFusion, QuadraticLimits

Vector = NDArray[np.float64]
ROBOT = robots.load("talos_reduced").core
STEPS_PER_JOINT = 12
"""The search's own."""


class Drawn:
    """A state of a robot whose motors have `torque_share` of their torque, and what asks for far more than that."""

    def __init__(self, rng: np.random.Generator, torque_share: float, speed_rad_s: float) -> None:
        robot = ROBOT
        n = self.joint_count = robot.joint_count
        self.limits = QuadraticLimits.of(robot)
        self.limits.torque = (torque_share * np.array(self.limits.torque)).tolist()
        lower, upper = np.maximum(robot.lower, -2), np.minimum(robot.upper, 2)
        self.position = rng.uniform(lower + 0.01, upper - 0.01)
        self.velocity = rng.uniform(-speed_rad_s, speed_rad_s, n)
        self.dynamics = RobotDynamics(robot)
        self.dynamics.update(self.position, self.velocity)
        bound = 0.9 * np.array(self.limits.torque)
        self.gravity = np.clip(self.dynamics.gravity_torque, -bound, bound)
        self.levels = [(300 * rng.normal(size=n), np.eye(n))]

    def fusion(self, steps: int) -> QuadraticFusion:
        self.limits.steps = steps
        return QuadraticFusion(self.joint_count, self.joint_count, 1, self.limits)

    def fuse(self, fusion: QuadraticFusion) -> Vector:
        return fusion.fuse(self.dynamics, self.position, self.velocity, self.gravity, self.levels)

    def acceleration_bounds(self) -> tuple[Vector, Vector]:
        limits = self.limits
        lower, upper, braking = (np.array(values) for values in (limits.lower, limits.upper, limits.braking))
        margin = np.minimum(limits.margin_rad, 0.05 * (upper - lower))
        up = np.sqrt(2 * braking * np.maximum(upper - margin - self.position, 0))
        down = np.sqrt(2 * braking * np.maximum(self.position - lower - margin, 0))
        low = (-np.minimum(down, limits.velocity) - self.velocity) / limits.horizon_s
        return low, (np.minimum(up, limits.velocity) - self.velocity) / limits.horizon_s


@pytest.mark.parametrize(("torque_share", "speed_rad_s"), [(0.5, 1.0), (0.25, 1.0)])
@pytest.mark.parametrize("steps", [0, 1, 3])
def test_a_cut_tick_keeps_every_limit_that_an_uncut_one_keeps(rng, torque_share, speed_rad_s, steps) -> None:
    searched = 0
    for _ in range(100):
        drawn = Drawn(rng, torque_share, speed_rad_s)
        fusion, whole = drawn.fusion(steps), drawn.fusion(2000)
        drawn.fuse(whole)
        for _ in range(2):
            torque = drawn.fuse(fusion)
            searched += fusion.report.room_steps > steps
            assert (np.abs(torque) <= np.array(drawn.limits.torque) + 1e-4).all()
            if fusion.report.widened:
                assert whole.report.widened
                continue
            low, high = drawn.acceleration_bounds()
            acceleration = drawn.dynamics.forward_dynamics(torque)
            assert (acceleration >= low - 1e-2).all()
            assert (acceleration <= high + 1e-2).all()
    assert searched > 0, "no search needed more steps than the tick had"


def test_what_gives_way_is_the_same_with_few_steps_and_with_enough(rng) -> None:
    widened = 0
    for _ in range(100):
        drawn = Drawn(rng, 0.5, 3.0)
        cut, whole = drawn.fusion(0), drawn.fusion(2000)
        drawn.fuse(cut)
        drawn.fuse(whole)
        assert cut.report.widened == whole.report.widened
        assert cut.report.room_steps == whole.report.room_steps
        widened += cut.report.widened
    assert widened > 3


def test_the_search_ends_within_its_own_steps_and_no_tick_takes_more(rng) -> None:
    """Harder than any robot is driven: a quarter of the torque, and every joint fast."""
    for number in range(150):
        drawn = Drawn(rng, 0.25, 3.0)
        if number % 2 == 0:
            fusion = drawn.fusion(30)  # the next state begins with what this one, unlike it, has met
        drawn.fuse(fusion)
        most = STEPS_PER_JOINT * drawn.joint_count
        assert fusion.report.room_steps < most
        assert fusion.report.steps <= max(30, fusion.report.room_steps)
