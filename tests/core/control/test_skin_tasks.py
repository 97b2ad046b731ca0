# SPDX-License-Identifier: Apache-2.0
"""Tasks of touch obey their equations, and claim what they move."""

import numpy as np
import pytest
from moment import CELLS, PERIOD_S, Moment, last_link
from random_skin import random_posture

from robotskin import robots
from robotskin.model import BASE
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.skin import Health
from robotskin.tasks import (
    ContactImpedanceGains,
    ContactImpedanceTask,
    ControlError,
    ForceTask,
    MapSkinTask,
    SkinCartesianTask,
    SkinGains,
    SkinReactionTask,
    TouchWrench,
)


def test_skin_reaction_is_the_skin_task_and_claims_a_row_a_touched_body(moment, robot) -> None:
    task = SkinReactionTask(TouchWrench(robot, moment.skin, moment.gains))
    expected = TouchWrench(robot, moment.skin, moment.gains).compute(moment.dynamics, moment.state, moment.share)
    np.testing.assert_allclose(moment.update(task), expected, atol=1e-9)
    bodies = {moment.body_of(cell) for cell in range(CELLS)} - {BASE}
    assert len(task.rows) == len(bodies)
    # The torques of the bodies, each along its row, make up the whole.
    solved = np.linalg.lstsq(task.rows.T, expected, rcond=None)[0]
    np.testing.assert_allclose(task.rows.T @ solved, expected, atol=1e-6)


def test_skin_reaction_fades_in_without_a_step(moment, robot) -> None:
    cell = next(cell for cell in range(CELLS) if moment.body_of(cell) != BASE)
    moment.touch_only(np.array([], dtype=int))
    task = SkinReactionTask(TouchWrench(robot, moment.skin, moment.gains))
    torques, lengths = [], []
    for force in np.linspace(0, 3, 3000):
        moment.state.normal_force[cell] = force / 3
        torques.append(moment.update(task))
        lengths.append(np.linalg.norm(task.rows) if len(task.rows) else 0.0)
    assert np.abs(np.diff(torques, axis=0)).max() < 0.03
    assert np.abs(np.diff(lengths)).max() < 0.01
    assert lengths[0] == 0 < lengths[-1]


def test_masked_and_silent_cells_contribute_nothing_to_any_skin_task(moment, robot) -> None:
    tasks = [
        SkinReactionTask(TouchWrench(robot, moment.skin, moment.gains)),
        SkinCartesianTask(robot, TouchWrench(robot, moment.skin, moment.gains), last_link(robot)),
        ContactImpedanceTask(TouchWrench(robot, moment.skin, moment.gains)),
    ]
    moment.share[:] = 0
    for task in tasks:
        np.testing.assert_array_equal(moment.update(task), 0)
        assert len(task.rows) == 0
    moment.share[:] = 1
    moment.state.health[:] = Health.stale.value
    for task in tasks:
        np.testing.assert_array_equal(moment.update(task), 0)


def test_skin_cartesian_pushes_the_frame_with_the_limbs_forces(robot, rng) -> None:
    moment = Moment(robot, rng)
    link = last_link(robot)
    task = SkinCartesianTask(robot, TouchWrench(robot, moment.skin, moment.gains), link)
    torque = moment.update(task)
    limb, joint = set(), robot.joint_count - 1
    while joint != BASE:
        limb.add(joint)
        joint = robot.joint_parents[joint]
    alone = TouchWrench(robot, moment.skin, moment.gains)
    alone.compute(moment.dynamics, moment.state, moment.share)
    force = np.zeros(3)
    for cell, magnitude in enumerate(alone.magnitudes):
        if moment.body_of(cell) in limb:
            base_from_link = moment.dynamics.base_from_link(
                robot.link_index(moment.skin.link_names[moment.skin.link[cell]])
            )
            force -= magnitude * base_from_link[:3, :3] @ moment.skin.link_from_cell[cell][:3, 2]
    single = 1e-6 * float(alone.magnitudes.sum())  # their precision; some push against each other
    np.testing.assert_allclose(task.force, force, rtol=0, atol=single)
    jacobian = moment.dynamics.link_jacobian(robot.link_index(link))[:3]
    np.testing.assert_allclose(torque, jacobian.T @ force, rtol=0, atol=single * np.abs(jacobian).sum(0).max())


def test_one_limb_does_not_feel_the_touch_of_another(rng) -> None:
    robot = robots.load("dual_arm").core
    moment = Moment(robot, rng)
    links = robot.link_names
    left = next(link for link in reversed(links) if link.startswith("left"))
    shoulder = robot.joint_index("right_shoulder_pan_joint")
    on_right = np.array([cell for cell in range(CELLS) if moment.body_of(cell) >= shoulder])
    assert len(on_right) > 5
    moment.touch_only(on_right)
    task = SkinCartesianTask(robot, TouchWrench(robot, moment.skin, moment.gains), left)
    np.testing.assert_array_equal(moment.update(task), 0)


def test_contact_impedance_gives_the_point_its_acceleration(rng) -> None:
    """Eq. 26 at the first touch, where nothing is displaced yet: inertia x'' + damping x' = W."""
    robot = robots.load("ur5").core
    moment = Moment(robot, rng)
    cell = next(cell for cell in range(CELLS) if moment.body_of(cell) == robot.joint_count - 1)
    moment.touch_only(np.array([cell]))
    gains = ContactImpedanceGains(2.5, 14.0, 20.0)
    task = ContactImpedanceTask(TouchWrench(robot, moment.skin, moment.gains), gains)
    moment.start(task)
    torque = moment.update(task)
    share = np.linalg.norm(task.rows[0])
    assert share > 0
    alone = TouchWrench(robot, moment.skin, moment.gains)
    alone.compute(moment.dynamics, moment.state, moment.share)
    magnitude = alone.magnitudes[cell]
    base_from_link = moment.dynamics.base_from_link(robot.link_index(moment.skin.link_names[moment.skin.link[cell]]))
    wrench = -magnitude * base_from_link[:3, :3] @ moment.skin.link_from_cell[cell][:3, 2]
    share = magnitude**2 / (magnitude**2 + 1)
    jacobian = task.rows / share
    acceleration = jacobian @ moment.dynamics.solve_mass(torque)
    expected = share * (wrench - 14.0 * jacobian @ moment.v) / 2.5
    np.testing.assert_allclose(acceleration, expected, rtol=1e-2, atol=1e-2)


def test_contact_impedance_comes_to_rest_where_the_spring_holds_the_push() -> None:
    """A steady push displaces the point by W / K."""
    rng = np.random.default_rng(7)
    robot = robots.load("ur5").core
    moment = Moment(robot, rng, at_rest=True)
    moment.move_to(np.array([0.0, -1.2, 1.4, -1.0, -1.5, 0.0]))
    cell = next(cell for cell in range(CELLS) if moment.body_of(cell) == robot.joint_count - 1)
    moment.touch_only(np.array([cell]))
    moment.state.proximity[:] = 0
    moment.state.normal_force[cell] = 2.0 / 3
    gains = SkinGains.uniform(CELLS, 1.0, 0.0, 0.5, 1.0, 0.1, 0.3)
    task = ContactImpedanceTask(TouchWrench(robot, moment.skin, gains), ContactImpedanceGains(2.5, 40.0, 100.0))
    moment.start(task)
    link = robot.link_index(moment.skin.link_names[moment.skin.link[cell]])
    places, normals = [], []
    for _ in range(4000):
        torque = moment.update(task) + moment.dynamics.nonlinear_effects - 1.0 * moment.v
        v = moment.v + PERIOD_S * moment.dynamics.forward_dynamics(torque)
        moment.move_to(moment.q + PERIOD_S * v, v)
        pose = moment.dynamics.base_from_link(link) @ moment.skin.link_from_cell[cell]
        places.append(pose[:3, 3])
        normals.append(-pose[:3, 2])
    moved = places[-1] - places[0]
    assert np.linalg.norm(moved) == pytest.approx(2.0 / 100.0, rel=0.35)
    assert moved @ normals[0] > 0.8 * np.linalg.norm(moved)


def test_map_skin_task_recalls_what_the_map_says(moment, robot, rng) -> None:
    tiles = 3
    posture = np.array([random_posture(robot, rng)[0] for _ in range(tiles)])
    weight = rng.uniform(-1, 1, (tiles, CELLS, robot.joint_count))
    known = SensoryMotorMap("r", tuple(robot.joint_names), np.arange(CELLS), posture, weight)
    task = MapSkinTask(robot.joint_count, CELLS, moment.gains, posture, weight, 0.3)
    moment.start(task)
    alone = TouchWrench(robot, moment.skin, moment.gains)
    alone.compute(moment.dynamics, moment.state, moment.share)
    expected = 0.3 * known.reaction(moment.q, alone.magnitudes)
    torque = moment.update(task)
    np.testing.assert_allclose(torque, expected, atol=1e-6)
    assert task.recalled == known.nearest(moment.q)
    assert np.linalg.matrix_rank(np.vstack([task.rows, torque])) == 1
    # Another tile fades in.
    other = (task.recalled + 1) % tiles
    torques = [torque]
    moment.move_to(posture[other])
    for _ in range(300):
        torques.append(moment.update(task))
    whole = np.abs(torques[-1] - torques[0]).max()
    assert np.abs(np.diff(torques, axis=0)).max() <= 1.01 * whole * PERIOD_S / 0.25 * 2
    np.testing.assert_allclose(torques[-1], 0.3 * known.reaction(posture[other], alone.magnitudes), atol=1e-6)


def test_force_task_presses_until_the_skin_feels_the_force(rng) -> None:
    """Against a wall that answers with a spring the measured force comes to the one asked for."""
    robot = robots.load("ur5").core
    moment = Moment(robot, rng, at_rest=True)
    moment.move_to(np.array([0.0, -1.2, 1.4, -1.0, -1.5, 0.0]))
    link = last_link(robot)
    index = robot.link_index(link)
    cell = next(cell for cell in range(CELLS) if moment.body_of(cell) == robot.joint_count - 1)
    moment.touch_only(np.array([], dtype=int))
    task = ForceTask(robot, TouchWrench(robot, moment.skin, moment.gains.measured_force()), link)
    moment.start(task)
    pose = moment.dynamics.base_from_link(robot.link_index(moment.skin.link_names[moment.skin.link[cell]]))
    normal = (pose @ moment.skin.link_from_cell[cell])[:3, 2]
    task.request_force(8.0 * normal)
    start = moment.dynamics.base_from_link(index)[:3, 3]
    posture = moment.q.copy()
    for _ in range(6000):
        depth = (moment.dynamics.base_from_link(index)[:3, 3] - start) @ normal
        wall = max(3000 * depth, 0.0)
        moment.state.normal_force[cell] = wall / 3
        rows = moment.dynamics.link_jacobian(index)[:3]
        hold = 100 * (posture - moment.q) - 20 * moment.v
        torque = moment.update(task) + moment.dynamics.nonlinear_effects + hold - rows.T @ (wall * normal)
        v = moment.v + PERIOD_S * moment.dynamics.forward_dynamics(torque)
        moment.move_to(moment.q + PERIOD_S * v, v)
    assert task.measured @ normal == pytest.approx(8.0, abs=0.8)
    with pytest.raises(ControlError, match="at most 50"):
        task.request_force(np.array([0.0, 0.0, 60.0]))
