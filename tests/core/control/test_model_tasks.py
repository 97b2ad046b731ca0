# SPDX-License-Identifier: Apache-2.0
"""Tasks of the robot's own motion obey their equations, and their rows are its true motions."""

import numpy as np
from moment import PERIOD_S, last_link
from random_skin import random_posture

from robotskin.tasks import (
    CartesianGains,
    CartesianTask,
    GravityTask,
    JointGains,
    JointLimitGains,
    JointLimitTask,
    JointTask,
    SplineCartesianTask,
    SplineJointTask,
)


def random_pose(rng: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    pose[:3, :3] = turn * np.sign(np.linalg.det(turn))
    pose[:3, 3] = rng.uniform(-1, 1, 3)
    return pose


def gains_of(count: int, rng: np.random.Generator) -> JointGains:
    return JointGains(rng.uniform(1, 100, count).tolist(), rng.uniform(1, 10, count).tolist())


def test_joint_task_is_an_impedance_about_its_reference(moment, robot, rng) -> None:
    gains = gains_of(robot.joint_count, rng)
    task = JointTask(robot, gains)
    goal = random_posture(robot, rng)[0]
    moment.start(task)
    np.testing.assert_allclose(moment.update(task), -np.array(gains.damping) * moment.v, atol=1e-12)
    task.request_reference(goal)
    expected = np.array(gains.stiffness) * (goal - moment.q) - np.array(gains.damping) * moment.v
    np.testing.assert_allclose(moment.update(task), expected, atol=1e-9)
    np.testing.assert_array_equal(task.rows, np.eye(robot.joint_count))


def test_new_gains_come_smoothly(moment, robot, rng) -> None:
    task = JointTask(robot, JointGains([10.0] * robot.joint_count, [0.0] * robot.joint_count))
    moment.start(task)
    task.request_reference(np.clip(moment.q + 0.1, robot.lower, robot.upper))
    before = moment.update(task)
    task.request_gains(JointGains([20.0] * robot.joint_count, [0.0] * robot.joint_count))
    after = np.array([moment.update(task) for _ in range(2000)])
    steps = np.abs(np.diff(np.vstack([before, after]), axis=0))
    assert (steps.max(axis=0) <= 0.02 * np.abs(before) + 1e-12).all()
    np.testing.assert_allclose(after[-1], 2 * before, rtol=1e-3, atol=1e-9)


def test_spline_joint_task_arrives_within_its_speed_and_without_steps(moment, robot, rng) -> None:
    speed = 0.5
    task = SplineJointTask(robot, gains_of(robot.joint_count, rng), speed)
    moment.start(task)
    moment.update(task)
    goal = random_posture(robot, rng)[0]
    task.request_reference(goal)
    references = [task.reference]
    for tick in range(40_000):
        moment.update(task)
        references.append(task.reference)
        if tick == 300:  # a change of mind under way
            goal = random_posture(robot, rng)[0]
            task.request_reference(goal)
        if tick > 300 and task.arrived:
            break
    np.testing.assert_allclose(task.reference, goal, atol=1e-9)
    velocity = np.diff(references, axis=0) / PERIOD_S
    acceleration = np.diff(velocity, axis=0) / PERIOD_S
    assert np.abs(velocity).max() <= 1.6 * speed  # the speed is that of a motion from rest
    assert np.abs(acceleration).max() < 60, "the reference has a kink"


def test_cartesian_rows_are_the_motion_of_the_frame(moment, robot) -> None:
    link = last_link(robot)
    task = CartesianTask(robot, link, CartesianGains([1.0] * 6, [1.0] * 6))
    moment.start(task)
    moment.update(task)
    pose = moment.dynamics.base_from_link(robot.link_index(link))
    step = 1e-6
    rows = task.rows
    for joint in range(robot.joint_count):
        moved = moment.q.copy()
        moved[joint] += step
        moment.dynamics.update(moved, moment.v)
        other = moment.dynamics.base_from_link(robot.link_index(link))
        turn = (other[:3, :3] @ pose[:3, :3].T - np.eye(3)) / step
        numeric = np.concatenate([(other - pose)[:3, 3] / step, [turn[2, 1], turn[0, 2], turn[1, 0]]])
        np.testing.assert_allclose(rows[:, joint], numeric, atol=1e-5)


def test_cartesian_torque_is_the_gradient_of_its_energy(moment, robot, rng) -> None:
    stiffness = np.array([*rng.uniform(10, 100, 3), 0, 0, 0])
    link = robot.link_index(last_link(robot))
    task = CartesianTask(robot, last_link(robot), CartesianGains(stiffness.tolist(), [0.0] * 6))
    goal = random_pose(rng)
    moment.start(task)
    task.request_reference(goal)
    torque = moment.update(task)
    assert task.rows.shape == (3, robot.joint_count), "axes without gains are free"

    def energy(q: np.ndarray) -> float:
        moment.dynamics.update(q, moment.v)
        gap = goal[:3, 3] - moment.dynamics.base_from_link(link)[:3, 3]
        return 0.5 * float(gap @ (stiffness[:3] * gap))

    step = 1e-6 * np.eye(robot.joint_count)
    numeric = [-(energy(moment.q + one) - energy(moment.q - one)) / 2e-6 for one in step]
    np.testing.assert_allclose(torque, numeric, atol=1e-4)


def test_cartesian_orientation_error_turns_the_frame_to_its_reference(moment, robot, rng) -> None:
    task = CartesianTask(robot, last_link(robot), CartesianGains([1.0] * 6, [0.0] * 6))
    goal = random_pose(rng)
    moment.start(task)
    task.request_reference(goal)
    moment.update(task)
    angle = np.linalg.norm(task.error[3:])
    axis = task.error[3:] / angle
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    now = moment.dynamics.base_from_link(robot.link_index(last_link(robot)))[:3, :3]
    np.testing.assert_allclose(turn @ now, goal[:3, :3], atol=1e-9)


def test_spline_cartesian_task_goes_straight_and_arrives(moment, robot, rng) -> None:
    task = SplineCartesianTask(robot, last_link(robot), CartesianGains([10.0] * 6, [1.0] * 6), 0.2, 1.0)
    moment.start(task)
    moment.update(task)
    begin, goal = task.reference, random_pose(rng)
    task.request_reference(goal)
    places = []
    for _ in range(30_000):
        moment.update(task)
        places.append(task.reference)
        if task.arrived:
            break
    np.testing.assert_allclose(places[-1], goal, atol=1e-9)
    way = goal[:3, 3] - begin[:3, 3]
    gone = np.array(places)[:, :3, 3] - begin[:3, 3]
    along = gone @ way / (way @ way)
    np.testing.assert_allclose(gone, along[:, None] * way, atol=1e-9)
    assert np.linalg.norm(np.diff(np.array(places)[:, :3, 3], axis=0), axis=1).max() / PERIOD_S <= 0.2 + 1e-6
    for place in places[:: len(places) // 7]:
        np.testing.assert_allclose(place[:3, :3] @ place[:3, :3].T, np.eye(3), atol=1e-9)


def test_gravity_task_holds_the_robot(moment, robot) -> None:
    task = GravityTask(robot.joint_count)
    moment.move_to(moment.q)
    np.testing.assert_allclose(moment.dynamics.forward_dynamics(moment.update(task)), 0, atol=1e-7)
    assert len(task.rows) == 0


def test_joint_limit_task_acts_only_near_a_limit_and_away_from_it(moment, robot, rng) -> None:
    gains = JointLimitGains()
    task = JointLimitTask(robot, gains)
    bounded = np.isfinite(robot.lower)
    middle = np.where(bounded, 0.5 * (robot.lower + robot.upper), 0.0)
    moment.move_to(middle)
    np.testing.assert_array_equal(moment.update(task), 0)
    assert len(task.rows) == 0
    moment.move_to(np.where(bounded, robot.upper, 0.0))
    assert (moment.update(task)[bounded] < 0).all()
    moment.move_to(np.where(bounded, robot.lower, 0.0))
    assert (moment.update(task)[bounded] > 0).all()
    np.testing.assert_allclose(task.rows, np.eye(robot.joint_count)[bounded])
    # On the way from the margin to the limit neither torque nor rows step.
    joint = int(np.flatnonzero(bounded)[0])
    before = np.zeros(2)
    for depth in np.linspace(0, gains.margin_rad, 200):
        q = middle.copy()
        q[joint] = robot.upper[joint] - gains.margin_rad + depth
        moment.move_to(q)
        torque = moment.update(task)[joint]
        now = np.array([torque, task.rows[0, joint] if len(task.rows) else 0.0])
        assert (np.abs(now - before) < [0.3, 0.03]).all()
        before = now
