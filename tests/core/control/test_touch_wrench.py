# SPDX-License-Identifier: Apache-2.0
"""The skin task: sum of Jᵀ W (eq. 14 to 17), whatever way it is computed."""

import numpy as np
import pinocchio
import pytest
from random_skin import at_random_posture, random_posture, random_skin, random_state

from robotskin import robots
from robotskin.model import ModelError, RobotDynamics, RobotModel
from robotskin.skin import Health, SkinModel
from robotskin.tasks import ControlError, SkinGains, TouchWrench
from robotskin_lab._lab.baselines import NaiveSkinTask

CELLS = 300


def gains(cells: int = CELLS) -> SkinGains:
    return SkinGains.uniform(cells, 3.0, 20.0, 0.5, 1.5, 0.1, 0.3)


def all_on(cells: int = CELLS) -> np.ndarray:
    return np.ones(cells, dtype=np.float32)


def activated(value: np.ndarray, silent: float, full: float) -> np.ndarray:
    share = np.clip((value - silent) / (full - silent), 0, 1)
    return value * share**2 * (3 - 2 * share)


@pytest.mark.parametrize("grouped", [False, True])
def test_torque_is_the_sum_of_jacobian_transposed_times_wrench(robot, rng, grouped) -> None:
    skin, state = random_skin(robot, CELLS, rng, grouped), random_state(CELLS, rng)
    dynamics = at_random_posture(robot, rng)
    task = TouchWrench(robot, skin, gains())
    torque = task.compute(dynamics, state, all_on())
    assert np.abs(torque).max() > 1
    naive = NaiveSkinTask(robot, skin)
    # The task works in single precision: an error is relative to what single cells ask for, not to what is left of it.
    asked = sum(np.abs(naive.compute(dynamics, magnitude)) for magnitude in np.diag(task.magnitudes))
    assert (np.abs(torque - naive.compute(dynamics, task.magnitudes)) <= 1e-6 * asked).all()


@pytest.mark.parametrize("grouped", [False, True])
def test_the_wrench_of_many_cells_is_as_exact_as_that_of_few(robot, rng, grouped) -> None:
    """A body's force and moment are the sums of those of its cells, however many there are."""
    cells = 20_000
    skin, state = random_skin(robot, cells, rng, grouped), random_state(cells, rng)
    dynamics = at_random_posture(robot, rng)
    task = TouchWrench(robot, skin, gains(cells))
    task.compute(dynamics, state, all_on(cells))
    link = np.array([robot.link_index(skin.link_names[i]) for i in skin.link])
    joint_from_cell = robot.joint_from_link[link] @ skin.link_from_cell
    force = -joint_from_cell[:, :3, 2] * task.magnitudes[:, None].astype(float)
    columns = np.hstack([force, np.cross(joint_from_cell[:, :3, 3], force)])
    wrenches = task.joint_wrenches
    for joint in range(robot.joint_count):
        on_body = columns[robot.link_joints[link] == joint]
        assert (np.abs(wrenches[joint] - on_body.sum(0)) <= 5e-7 * np.abs(on_body).sum(0)).all()


def test_torque_equals_that_of_pinocchio(seed: int, rng) -> None:
    robot = robots.load("ur5")
    skin, state = random_skin(robot.core, CELLS, rng), random_state(CELLS, rng)
    q, v = random_posture(robot.core, rng)
    dynamics = RobotDynamics(robot.core)
    dynamics.update(q, v)
    torque = TouchWrench(robot.core, skin, gains()).compute(dynamics, state, all_on())

    model = pinocchio.buildModelFromXML(robot.urdf)
    frames = []
    for cell in range(CELLS):
        link = model.getFrameId(skin.link_names[skin.link[cell]])
        placement = model.frames[link].placement * pinocchio.SE3(skin.link_from_cell[cell])
        kind = pinocchio.FrameType.OP_FRAME
        frames.append(model.addFrame(pinocchio.Frame(f"cell {cell}", model.frames[link].parentJoint, placement, kind)))
    data = model.createData()
    force = activated(state.normal_force.sum(1), 0.5, 1.5) * 3 + activated(state.proximity, 0.1, 0.3) * 20
    expected = np.zeros(model.nv)
    for frame, magnitude in zip(frames, force, strict=True):
        jacobian = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.ReferenceFrame.LOCAL)
        expected += jacobian[:3].T @ np.array([0, 0, -magnitude])
    # The forces are single precision.
    np.testing.assert_allclose(torque, expected, rtol=1e-5, atol=1e-4)


def test_virtual_power_is_that_of_the_forces(robot, rng) -> None:
    skin, state = random_skin(robot, CELLS, rng), random_state(CELLS, rng)
    q, v = random_posture(robot, rng)
    dynamics = RobotDynamics(robot)
    dynamics.update(q, v)
    task = TouchWrench(robot, skin, gains())
    joint_power = task.compute(dynamics, state, all_on()) @ v
    step = 1e-6
    places = []
    for way in (-1, 1):
        dynamics.update(q + way * step * v, v)
        base_from_cell = np.array(
            [
                dynamics.base_from_link(robot.link_index(skin.link_names[link])) @ pose
                for link, pose in zip(skin.link, skin.link_from_cell, strict=True)
            ]
        )
        places.append(base_from_cell)
    velocity = (places[1][:, :3, 3] - places[0][:, :3, 3]) / (2 * step)
    normal = (places[1][:, :3, 2] + places[0][:, :3, 2]) / 2
    cell_power = -(task.magnitudes[:, None] * normal * velocity).sum()
    assert joint_power == pytest.approx(cell_power, rel=1e-6)


def test_a_touch_pushes_the_robot_away(rng) -> None:
    """The acceleration of the touched point has a component along -z."""
    robot = robots.load("ur5").core
    skin, state = random_skin(robot, 50, rng), random_state(50, rng)
    dynamics = at_random_posture(robot, rng)
    task = TouchWrench(robot, skin, gains(50))
    for cell in range(50):
        share = np.zeros(50, dtype=np.float32)
        share[cell] = 1
        torque = task.compute(dynamics, state, share)
        # tau^T M^-1 tau > 0 is the acceleration along the force, times the force.
        assert torque @ dynamics.solve_mass(torque) >= 0
        link = robot.link_index(skin.link_names[skin.link[cell]])
        base_from_link, jacobian = dynamics.base_from_link(link), dynamics.link_jacobian(link)
        normal = base_from_link[:3, :3] @ skin.link_from_cell[cell][:3, 2]
        arm = base_from_link[:3, :3] @ skin.link_from_cell[cell][:3, 3]
        twist = jacobian @ torque
        velocity = twist[:3] + np.cross(twist[3:], arm)
        assert velocity @ normal <= 1e-9


@pytest.mark.parametrize("health", [health for health in Health if health != Health.alive])
def test_a_cell_that_is_not_alive_contributes_nothing(robot, rng, health) -> None:
    skin, state = random_skin(robot, CELLS, rng), random_state(CELLS, rng)
    dynamics = at_random_posture(robot, rng)
    task = TouchWrench(robot, skin, gains())
    gone = rng.random(CELLS) < 0.5
    share = np.where(gone, 0, 1).astype(np.float32)
    masked = task.compute(dynamics, state, share)
    state.health[gone] = health.value
    np.testing.assert_array_equal(task.compute(dynamics, state, all_on()), masked)
    assert not task.magnitudes[gone].any()
    state.health[:] = health.value
    assert not task.compute(dynamics, state, all_on()).any()


def test_impossible_values_give_no_impossible_torque(robot, rng) -> None:
    skin, state = random_skin(robot, CELLS, rng), random_state(CELLS, rng)
    dynamics = at_random_posture(robot, rng)
    task = TouchWrench(robot, skin, gains())
    state.normal_force[0] = np.nan
    state.normal_force[1] = np.inf
    state.normal_force[2] = -np.inf
    state.proximity[3] = np.nan
    state.proximity[4] = 1e30
    assert np.isfinite(task.compute(dynamics, state, all_on())).all()
    assert np.abs(task.magnitudes).max() <= 3 * 30 + 20


def test_activation_has_no_step_and_ends_at_the_whole_force(robot, rng) -> None:
    skin = random_skin(robot, 1, rng)
    state, dynamics = random_state(1, rng), at_random_posture(robot, rng)
    state.proximity[:] = 0
    task = TouchWrench(robot, skin, gains(1))
    force = np.linspace(0, 3, 3001)
    asked = []
    for value in force:
        state.normal_force[:] = value / 3
        task.compute(dynamics, state, all_on(1))
        asked.append(task.magnitudes[0])
    asked = np.array(asked)
    assert not asked[force <= 0.5].any()
    np.testing.assert_allclose(asked[force >= 1.5], 3 * force[force >= 1.5], rtol=1e-5)
    slope = np.diff(asked) / np.diff(force)
    assert (slope >= -1e-3).all()
    assert slope.max() < 3 * 4
    assert np.abs(np.diff(slope)).max() < 0.1


def test_what_does_not_fit_is_refused(robot, rng) -> None:
    skin = random_skin(robot, 5, rng)
    with pytest.raises(ControlError, match=r"force_weight has 4 values, the skin has 5 cells"):
        TouchWrench(robot, skin, gains(4))
    wrong = gains(5)
    wrong.force_full = [0.2] * 5
    with pytest.raises(ControlError, match=r"force_full of cell 0 is 0\.2.*greater"):
        TouchWrench(robot, skin, wrong)
    wrong = gains(5)
    wrong.proximity_weight = [1, 1, float("nan"), 1, 1]
    with pytest.raises(ControlError, match="proximity_weight of cell 2 is nan"):
        TouchWrench(robot, skin, wrong)
    stranger = SkinModel(
        link_names=["no_such_link"],
        key=skin.key,
        link=np.zeros(5, dtype=np.int32),
        link_from_cell=skin.link_from_cell,
        neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (5, 4, 1)),
        patch=skin.patch,
    )
    with pytest.raises(ModelError, match="no_such_link"):
        TouchWrench(robot, stranger, gains(5))
    with pytest.raises(ValueError, match="one entry a cell"):
        TouchWrench(robot, skin, gains(5)).compute(at_random_posture(robot, rng), random_state(4, rng), all_on(5))


def test_a_skin_on_the_base_moves_nothing(rng) -> None:
    robot: RobotModel = robots.load("ur5").core
    skin = SkinModel(
        link_names=[robot.link_names[0]],
        key=np.arange(1, 4, dtype=np.uint32),
        link=np.zeros(3, dtype=np.int32),
        link_from_cell=np.tile(np.eye(4), (3, 1, 1)),
        neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (3, 4, 1)),
        patch=np.zeros(3, dtype=np.int32),
    )
    task = TouchWrench(robot, skin, gains(3))
    assert not task.compute(at_random_posture(robot, rng), random_state(3, rng), all_on(3)).any()
