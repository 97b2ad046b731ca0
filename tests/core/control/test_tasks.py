# SPDX-License-Identifier: Apache-2.0
"""Each task of the library obeys its equation, and its rows are true motions of the robot."""

import numpy as np
import pytest
from random_skin import random_posture, random_skin, random_state

from robotskin import robots
from robotskin.model import BASE, ModelError, RobotDynamics, RobotModel
from robotskin.selfconfig.map.sensory_motor_map import SensoryMotorMap
from robotskin.skin import Health, SkinState
from robotskin.tasks import (
    CartesianGains,
    CartesianTask,
    ContactImpedanceGains,
    ContactImpedanceTask,
    ControlError,
    ForceTask,
    GravityTask,
    JointGains,
    JointLimitGains,
    JointLimitTask,
    JointTask,
    MapSkinTask,
    PythonTask,
    SelfCollisionGains,
    SelfCollisionTask,
    SkinCartesianTask,
    SkinGains,
    SkinReactionTask,
    SplineCartesianTask,
    SplineJointTask,
    Task,
    TouchWrench,
)

CELLS = 200
PERIOD_S = 0.001


class Moment:
    """A robot in a state, with a touched skin."""

    def __init__(self, robot: RobotModel, rng: np.random.Generator, at_rest: bool = False) -> None:
        self.robot, self.rng = robot, rng
        self.skin, self.state = random_skin(robot, CELLS, rng), random_state(CELLS, rng)
        self.share = np.ones(CELLS, dtype=np.float32)
        self.gains = SkinGains.uniform(CELLS, 3.0, 20.0, 0.5, 1.5, 0.1, 0.3)
        self.dynamics = RobotDynamics(robot)
        self.move_to(*random_posture(robot, rng))
        if at_rest:
            self.move_to(self.q, np.zeros_like(self.v))

    def move_to(self, q: np.ndarray, v: np.ndarray | None = None) -> None:
        self.q, self.v = q, np.zeros_like(q) if v is None else v
        self.dynamics.update(self.q, self.v)

    def start(self, task: Task) -> None:
        task.start(self.dynamics, self.q, self.v, self.state, self.share, PERIOD_S)

    def update(self, task: Task) -> np.ndarray:
        task.update(self.dynamics, self.q, self.v, self.state, self.share, PERIOD_S)
        return task.torque

    def body_of(self, cell: int) -> int:
        return self.robot.link_joints[self.robot.link_index(self.skin.link_names[self.skin.link[cell]])]

    def touch_only(self, cells: np.ndarray) -> None:
        untouched = np.setdiff1d(np.arange(CELLS), cells)
        self.state.normal_force[untouched] = 0
        self.state.proximity[untouched] = 0


@pytest.fixture
def moment(robot: RobotModel, rng: np.random.Generator) -> Moment:
    return Moment(robot, rng)


def last_link(robot: RobotModel) -> str:
    return robot.link_names[int(np.flatnonzero(robot.link_joints == robot.joint_count - 1)[0])]


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


def test_a_task_of_the_user_in_python(moment, robot) -> None:
    n = robot.joint_count

    def compute(dynamics, position, velocity, skin):
        return -3.0 * position - velocity, np.eye(n)[:2]

    task = PythonTask("mine", n, 2, compute)
    np.testing.assert_allclose(moment.update(task), -3.0 * moment.q - moment.v)
    np.testing.assert_array_equal(task.rows, np.eye(n)[:2])
    assert task.error == ""

    broken = PythonTask("broken", n, 0, lambda *_: 1 / 0)
    with pytest.raises(ValueError, match="no answer"):
        moment.update(broken)
    assert "ZeroDivisionError" in broken.error


def test_what_does_not_fit_is_refused_by_name(robot, rng) -> None:
    n = robot.joint_count
    skin = random_skin(robot, CELLS, rng)
    fine = SkinGains.uniform(CELLS, 1, 1, 0.5, 1.5, 0.1, 0.3)
    pose = CartesianGains([1.0] * 6, [1.0] * 6)
    with pytest.raises(ControlError, match="stiffness has 5 values, there are 6 axes"):
        CartesianGains([1.0] * 5, [1.0] * 6)
    with pytest.raises(ModelError, match="no_such_link"):
        CartesianTask(robot, "no_such_link", pose)
    with pytest.raises(ControlError, match="base"):
        CartesianTask(robot, robot.link_names[0], pose)
    with pytest.raises(ControlError, match="stiffness nan"):
        CartesianTask(robot, last_link(robot), CartesianGains([np.nan] * 6, [1.0] * 6))
    with pytest.raises(ControlError, match=f"{n + 1} values"):
        JointTask(robot, JointGains([1.0] * (n + 1), [1.0] * n))
    with pytest.raises(ControlError, match="reference"):
        JointTask(robot, JointGains([1.0] * n, [1.0] * n)).request_reference(np.full(n, np.nan))
    with pytest.raises(ControlError, match="rotation"):
        CartesianTask(robot, last_link(robot), pose).request_reference(2 * np.eye(4))
    with pytest.raises(ControlError, match="speed"):
        SplineJointTask(robot, JointGains([1.0] * n, [1.0] * n), 0.0)
    with pytest.raises(ControlError, match="values, the skin has"):
        SkinReactionTask(TouchWrench(robot, skin, SkinGains.uniform(CELLS - 1, 1, 1, 0.5, 1.5, 0.1, 0.3)))
    with pytest.raises(ModelError, match="no_such_link"):
        SkinCartesianTask(robot, TouchWrench(robot, skin, fine), "no_such_link")
    with pytest.raises(ControlError, match="inertia"):
        ContactImpedanceTask(TouchWrench(robot, skin, fine), ContactImpedanceGains(0.0, 1.0, 1.0))
    with pytest.raises(ControlError, match="weight has"):
        MapSkinTask(n, CELLS, fine, np.zeros((2, n)), np.zeros((1, CELLS, n)), 0.1)
    task = SkinReactionTask(TouchWrench(robot, skin, fine))
    moment = Moment(robot, rng)
    with pytest.raises(ValueError, match="skin must have its cells"):
        task.update(moment.dynamics, moment.q, moment.v, SkinState(CELLS - 1), moment.share, PERIOD_S)


# ---- Self-collision and force ----


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
