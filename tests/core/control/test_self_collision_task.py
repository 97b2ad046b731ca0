# SPDX-License-Identifier: Apache-2.0
"""A robot keeps its bodies apart: rows are the rate of a distance, and only what is near acts."""

import numpy as np
import pytest
from moment import Moment

from robotskin import robots
from robotskin.model import ModelError, RobotModel
from robotskin.tasks import SelfCollisionGains, SelfCollisionTask


def box(size: float) -> np.ndarray:
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
    return np.ascontiguousarray(0.5 * size * corners)


def spread_boxes(robot: RobotModel) -> SelfCollisionTask:
    """A box on every body, every pair of bodies that are no neighbours, a safe distance that many pairs break."""
    gains = SelfCollisionGains()
    gains.safe_m = 0.3
    hulls = [(joint, box(0.05)) for joint in range(-1, robot.joint_count)]
    pairs = [(a, b) for a in range(len(hulls)) for b in range(a + 2, len(hulls))]
    return SelfCollisionTask(robot, hulls, pairs, gains)


def test_rows_of_self_collision_are_the_rate_of_the_distance(moment, robot) -> None:
    task = spread_boxes(robot)
    moment.update(task)
    rows, near = task.rows, {one.pair: one for one in task.near if one.distance_m > 0.01}
    order = [one.pair for one in task.near]
    assert near
    step = 1e-6
    changed = np.zeros((robot.joint_count, 2, len(order)))
    for joint in range(robot.joint_count):
        for side, sign in enumerate((1, -1)):
            q = moment.q.copy()
            q[joint] += sign * step
            moment.dynamics.update(q, moment.v)
            moment.update(task)
            found = {one.pair: one.distance_m for one in task.near}
            changed[joint, side] = [found.get(pair, np.nan) for pair in order]
    compared = 0
    for index, pair in enumerate(order):
        if pair not in near:
            continue
        missing = 0.3 - near[pair].distance_m
        share = (missing / 0.3) ** 2 * (3 - 2 * missing / 0.3)
        numeric = (changed[:, 0, index] - changed[:, 1, index]) / (2 * step)
        if np.isfinite(numeric).all() and share > 1e-3:
            # Where the nearest points jump from one corner to another the distance has a kink.
            agree = np.abs(rows[index] / share - numeric) < 1e-3
            compared += agree.all()
            assert agree.mean() > 0.9
    assert compared > 0


def test_self_collision_pushes_apart_and_only_what_is_near(rng) -> None:
    robot = robots.load("ur5").core
    moment = Moment(robot, rng, at_rest=True)
    task = spread_boxes(robot)
    torque = moment.update(task)
    assert (task.rows @ moment.dynamics.solve_mass(torque)).sum() > 0
    assert task.measured <= 30
    far = SelfCollisionTask(robot, [(-1, box(0.01)), (5, box(0.01))], [(0, 1)])
    np.testing.assert_array_equal(moment.update(far), 0)
    assert far.near == []
    assert len(far.rows) == 0


def test_distance_is_that_of_the_boxes(rng) -> None:
    """Two boxes of 0.1 m, 0.4 m apart along x: their faces are 0.3 m apart."""
    robot = robots.load("ur5").core
    moment = Moment(robot, rng)
    shifted = box(0.1) + np.array([0.4, 0.0, 0.0])
    gains = SelfCollisionGains()
    gains.safe_m = 0.5
    task = SelfCollisionTask(robot, [(-1, box(0.1)), (-1, shifted)], [(0, 1)], gains)
    moment.update(task)
    (pair,) = task.near
    assert pair.distance_m == pytest.approx(0.3, abs=1e-6)
    np.testing.assert_allclose(pair.a_to_b, [1, 0, 0], atol=1e-6)


def test_hulls_and_pairs_that_are_none_are_refused(robot) -> None:
    with pytest.raises(ModelError, match="four points"):
        SelfCollisionTask(robot, [(0, np.zeros((3, 3)))], [])
    with pytest.raises(ModelError, match="joint 99"):
        SelfCollisionTask(robot, [(99, box(1.0))], [])
    with pytest.raises(ModelError, match="pair"):
        SelfCollisionTask(robot, [(0, box(1.0))], [(0, 1)])
