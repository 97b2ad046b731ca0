# SPDX-License-Identifier: Apache-2.0
"""States of Talos in which five levels meet many limits at once, and which once took 5 to 16 ms, stay cheap and exact.

The file holds, for ten states of the stacks that `robotskin bench control` times (seeds 2, 4, 5, 8 and 17, whole and
quarter torque limits): position and velocity (n), torque limits and feedforward torque (n), and torque (n) and rows
(s, n) of every level.
"""

from pathlib import Path

import numpy as np
import pytest

from robotskin import robots
from robotskin.model import RobotDynamics
from robotskin.tasks import QuadraticFusion, QuadraticLimits

FILE = Path(__file__).with_name("costly_states.npz")
LEVELS = 5


@pytest.mark.parametrize("case", range(10))
def test_a_costly_state_is_exact_within_the_steps_of_a_tick(case: int) -> None:
    robot = robots.load("talos").core
    with np.load(FILE) as file:
        position, velocity = file[f"position_{case}"], file[f"velocity_{case}"]
        bound, feedforward = file[f"limit_{case}"], file[f"feedforward_{case}"]
        levels = [(file[f"torque_{case}_{level}"], file[f"rows_{case}_{level}"]) for level in range(LEVELS)]
    dynamics = RobotDynamics(robot)
    dynamics.update(position, velocity)
    limits = QuadraticLimits.of(robot)
    limits.torque = bound.tolist()
    rows = sum(len(own) for _, own in levels)
    fusion = QuadraticFusion(robot.joint_count, rows, LEVELS, limits)
    cold = fusion.fuse(dynamics, position, velocity, feedforward, levels)
    assert not fusion.report.fallback
    assert fusion.report.steps < 350, "without a tick before it"
    assert fusion.constrained >= 2, "the state meets limits"
    assert (np.abs(cold) <= bound + 1e-5).all()
    warm = fusion.fuse(dynamics, position, velocity, feedforward, levels)
    assert fusion.report.steps < 150, "beginning with the limits of the tick before"
    np.testing.assert_allclose(warm, cold, atol=1e-4 * np.abs(cold).max())
