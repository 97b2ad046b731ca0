# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pinocchio
import pytest
from scipy.spatial.transform import Rotation

from robotskin.robots import Robot, from_text, load
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.kinematics.adjustment import KinematicAdjustment, KinematicState
from robotskin.selfconfig.kinematics.estimate import KinematicEstimate
from robotskin.selfconfig.kinematics.kinematics import estimate_kinematics, settled
from robotskin.selfconfig.kinematics.start import KinematicsError
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.readings.swing_statistics import SwingStatistics, swing_signals
from robotskin.selfconfig.reconstruction.rigid_patches import RigidPatches
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults
from robotskin.selfconfig.simulated.skin import SimulatedSkin

IMPERFECT = AccelerometerImperfections.ideal()
IDEAL = AccelerometerImperfections.none()
UR5_LINKS = ["shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link"]


def true_patches(skin: SimulatedSkin) -> RigidPatches:
    """The patches as a perfect reconstruction would give them."""
    patch = skin.topology.patch
    pose = np.linalg.inv(skin.link_from_cell[skin.topology.root[patch]]) @ skin.link_from_cell
    count = len(patch)
    return RigidPatches(patch, pose, np.full(count, 1e-3), np.zeros((count, 3, 3)))


def swings_of(
    robot: Robot, joints: list[int], random: np.random.Generator, postures: int = 3, amplitude: float = 0.12
) -> list[JointSine]:
    span = np.minimum(robot.upper - 0.3, 1.5), np.maximum(robot.lower + 0.3, -1.5)
    centres = [random.uniform(np.minimum(*span), np.maximum(*span)) for _ in range(postures)]
    return [JointSine(joint, centre, amplitude, 1.25, 3.2) for joint in joints for centre in centres]


def recorded(
    skin: SimulatedSkin, swings: list[JointSine], random: np.random.Generator, kind: AccelerometerImperfections
) -> tuple[list[MotionRecording], tuple[np.ndarray, GravitySamples]]:
    faults = AccelerometerFaults.draw(random, len(skin.link), kind)
    postures = np.array([random.uniform(-1.5, 1.5, skin.robot.joint_count) for _ in range(6)])
    return skin.swings(swings, faults, random, kind), (postures, skin.rest_readings(postures, faults, random, kind))


def heading_aligned(estimated: np.ndarray, true: np.ndarray) -> np.ndarray:
    """(4, 4) true_from_estimated: the turn about z and the shift that best bring points over each other."""
    a, b = estimated - estimated.mean(axis=0), true - true.mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a[:, :2] * b[:, :2]))
    result = np.eye(4)
    result[:3, :3] = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    result[:3, 3] = true.mean(axis=0) - result[:3, :3] @ estimated.mean(axis=0)
    return result


def cell_errors(
    estimate: KinematicEstimate, skin: SimulatedSkin, cells: np.ndarray, random: np.random.Generator, count: int = 20
) -> tuple[float, float]:
    """Largest error of the cells' places, m, and rotations, rad, over random postures, gauge aligned."""
    postures = [random.uniform(-1.5, 1.5, skin.robot.joint_count) for _ in range(count)]
    estimated = np.array([estimate.base_from_cell_at(q)[cells] for q in postures]).reshape(-1, 4, 4)
    true = np.array([skin.base_from_cell(q)[cells] for q in postures]).reshape(-1, 4, 4)
    aligned = heading_aligned(estimated[:, :3, 3], true[:, :3, 3]) @ estimated
    turned = Rotation.from_matrix(np.swapaxes(aligned[:, :3, :3], 1, 2) @ true[:, :3, :3]).magnitude()
    return float(np.linalg.norm(aligned[:, :3, 3] - true[:, :3, 3], axis=1).max()), float(turned.max())


@pytest.fixture(scope="module")
def arm(request: pytest.FixtureRequest) -> tuple[SimulatedSkin, KinematicEstimate]:
    """A UR5 with a few cells on five links, real accelerometers, and what came of it."""
    random = np.random.default_rng(request.config.getoption("--seed"))
    skin = SimulatedSkin.of_sleeves(load("ur5"), UR5_LINKS, random, 2, 2)
    recordings, rests = recorded(skin, swings_of(skin.robot, [*range(6)], random), random, IMPERFECT)
    return skin, estimate_kinematics(recordings, true_patches(skin), joint_names=skin.robot.joint_names, rests=rests)


def test_five_vectors_say_what_a_swing_says(seed: int) -> None:
    random = np.random.default_rng(seed)
    skin = SimulatedSkin.of_sleeves(load("ur5"), ["wrist_1_link"], random, 2, 1)
    for swing in swings_of(skin.robot, [0, 2, 3], random, postures=1):
        (recording,), _ = recorded(skin, [swing], random, IDEAL)
        fit = SwingStatistics.of_recording(recording)
        signals = swing_signals(*(swing.displacement(recording.time_s, order) for order in range(3)))
        assert np.allclose(signals @ fit.coefficient, recording.acceleration, atol=1e-6)


def test_ideal_readings_give_the_exact_robot(seed: int) -> None:
    random = np.random.default_rng(seed)
    skin = SimulatedSkin.of_sleeves(load("panda"), ["panda_link2", "panda_link4", "panda_link5"], random, 2, 1)
    recordings, rests = recorded(skin, swings_of(skin.robot, [0, 1, 2, 3, 4], random), random, IDEAL)
    estimate = estimate_kinematics(recordings, true_patches(skin), joint_names=skin.robot.joint_names, rests=rests)
    # Between link 2 and link 4 lie two joints and no cell: their order comes from the motion.
    assert estimate.tree.paths[-1] == (0, 1, 2, 3, 4)
    place, turn = cell_errors(estimate, skin, np.arange(len(skin.link)), random)
    assert place < 1e-5
    assert turn < 1e-5


def test_derivatives_are_those_of_the_residual(seed: int) -> None:
    random = np.random.default_rng(seed)
    skin = SimulatedSkin.of_sleeves(load("ur5"), ["upper_arm_link", "wrist_1_link"], random, 2, 1)
    recordings, _ = recorded(skin, swings_of(skin.robot, [0, 1, 2, 3], random, postures=2), random, IMPERFECT)
    patches = true_patches(skin)
    estimate = estimate_kinematics(recordings, patches, joint_names=skin.robot.joint_names)
    problem = KinematicAdjustment([SwingStatistics.of_recording(one) for one in recordings], patches)
    state = KinematicState(estimate.tree, estimate.rotation, estimate.offset, estimate.scale)
    unknowns, cells = 4 * len(estimate.joints) + 12, len(skin.link)
    # Away from the optimum, where the gradient is large.
    state = problem.moved(state, 0.02 * random.standard_normal(unknowns), 1e-3 * random.standard_normal((cells, 9)))
    weights = np.ones((len(recordings), cells))
    normal = problem.linearise(state, weights)
    step, size = random.standard_normal(unknowns), 1e-6

    def cost(length: float) -> float:
        # The cells' unknowns follow, as in the reduced equations.
        own = np.linalg.solve(normal.local, -np.einsum("nul,u->nl", normal.coupling, step)[..., None])[..., 0]
        moved = problem.moved(state, length * step, length * own)
        return problem.cost(moved, problem.residual(moved), weights)

    slope = (cost(size) - cost(-size)) / (2 * size)
    assert slope == pytest.approx(-normal.right @ step, rel=1e-4)


def test_real_accelerometers_give_axes_and_cells(arm: tuple[SimulatedSkin, KinematicEstimate], seed: int) -> None:
    skin, estimate = arm
    beyond = np.flatnonzero(skin.link > skin.robot.link_index("shoulder_link"))
    place, turn = cell_errors(estimate, skin, beyond, np.random.default_rng(seed + 1))
    assert place < 0.005
    assert turn < np.radians(0.5)
    assert np.degrees(estimate.axis_deviation_rad).max() < 0.3


def test_what_motion_does_not_tell_is_named_and_infinite(arm: tuple[SimulatedSkin, KinematicEstimate]) -> None:
    skin, estimate = arm
    shoulder = int(skin.topology.patch[np.argmax(skin.link == skin.robot.link_index("shoulder_link"))])
    assert [one.what for one in estimate.unobservable] == [
        *(f"the base frame, chosen by convention on shoulder_pan_joint: place along {axis}" for axis in "xyz"),
        "the base frame, chosen by convention on shoulder_pan_joint: angle about the vertical",
        f"patch {shoulder}: place along the axis of shoulder_pan_joint",
        f"patch {shoulder}: angle about the axis of shoulder_pan_joint",
        "the axis of wrist_3_joint, which moves no cell",
    ]
    assert all(one.variance == np.inf for one in estimate.unobservable)
    variance = np.diagonal(estimate.covariance, axis1=1, axis2=2)
    first = skin.topology.patch == shoulder
    assert np.isinf(variance[first][:, 3:]).all()
    assert np.isfinite(variance[~first]).all()


def test_unobservable_motions_leave_every_reading_as_it_was(
    arm: tuple[SimulatedSkin, KinematicEstimate], seed: int
) -> None:
    skin, estimate = arm
    random = np.random.default_rng(seed)
    recordings, _ = recorded(skin, swings_of(skin.robot, [0, 1, 3], random), random, IDEAL)
    problem = KinematicAdjustment([SwingStatistics.of_recording(one) for one in recordings], estimate.patches)
    state = KinematicState(estimate.tree, estimate.rotation, estimate.offset, estimate.scale)
    before = problem.residual(state)
    for motion in estimate.unobservable:
        if motion.twist is None:
            continue
        shift = pinocchio.exp6(pinocchio.Motion(0.3 * motion.twist)).homogeneous
        moved = estimate.tree.seen_from(shift)
        direction, point = estimate.tree.direction.copy(), estimate.tree.point.copy()
        rows = np.isin(estimate.joints, motion.joints)
        direction[rows], point[rows] = moved.direction[rows], moved.point[rows]
        pose = estimate.tree.base_from_root.copy()
        pose[list(motion.patches)] = moved.base_from_root[list(motion.patches)]
        tree = replace(estimate.tree, direction=direction, point=point, base_from_root=pose)
        # A first axis that is a hundredth of a degree off the vertical lets gravity change by some 1e-4 of itself.
        assert np.abs(problem.residual(replace(state, tree=tree)) - before).max() < 0.05 * np.abs(before).max(), motion


def test_true_cells_lie_within_the_stated_deviations(arm: tuple[SimulatedSkin, KinematicEstimate]) -> None:
    skin, estimate = arm
    beyond = np.flatnonzero(skin.link > skin.robot.link_index("shoulder_link"))
    true = skin.base_from_cell(np.zeros(6))
    aligned = heading_aligned(estimate.base_from_cell[beyond, :3, 3], true[beyond, :3, 3]) @ estimate.base_from_cell
    error = np.linalg.norm(aligned[beyond, :3, 3] - true[beyond, :3, 3], axis=1)
    deviation = np.sqrt(np.trace(estimate.covariance[beyond, 3:, 3:], axis1=1, axis2=2))
    assert (error < 4 * deviation).mean() > 0.9


def test_urdf_and_model_place_every_cell_where_the_estimate_does(
    arm: tuple[SimulatedSkin, KinematicEstimate], seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    skin, estimate = arm
    posture = np.random.default_rng(seed).uniform(-2, 2, 6)
    model = estimate.model()
    data = model.createData()
    q = np.zeros(model.nq)
    for joint in estimate.joints:
        q[model.joints[model.getJointId(skin.robot.joint_names[joint])].idx_q] = posture[joint]
    pinocchio.framesForwardKinematics(model, data, q)
    names = [estimate.link_names[index] for index in estimate.link]
    placed = np.array([data.oMf[model.getFrameId(name)].homogeneous for name in names]) @ estimate.link_from_cell
    assert np.allclose(placed, estimate.base_from_cell_at(posture), atol=1e-9)
    robot = from_text(estimate.urdf(), name="found", folder=tmp_path_factory.mktemp("urdf"))
    links = [robot.link_index(name) for name in names]
    order = [list(skin.robot.joint_names).index(name) for name in robot.joint_names]
    assert np.allclose(robot.base_from_link(posture[order])[links] @ estimate.link_from_cell, placed, atol=1e-9)


def test_a_bumped_cell_loses_its_say(seed: int) -> None:
    random = np.random.default_rng(seed)
    skin = SimulatedSkin.of_sleeves(load("ur5"), ["upper_arm_link", "forearm_link"], random, 2, 2)
    recordings, rests = recorded(skin, swings_of(skin.robot, [0, 1, 2], random), random, IMPERFECT)
    recordings[4].acceleration[3, 200:500] += [6.0, -4.0, 5.0]
    recordings[7].acceleration[5, :30] = np.nan
    estimate = estimate_kinematics(recordings, true_patches(skin), joint_names=skin.robot.joint_names, rests=rests)
    assert estimate.swing_weight[4, 3] < 0.05
    assert np.median(estimate.swing_weight) == 1.0
    assert cell_errors(estimate, skin, np.arange(len(skin.link)), random)[0] < 0.01


def test_branches_that_share_a_trunk_become_one_tree(seed: int) -> None:
    random = np.random.default_rng(seed)
    robot = load("talos")
    links = ["torso_2_link", "arm_left_2_link", "arm_left_4_link", "arm_right_2_link"]
    skin = SimulatedSkin.of_sleeves(robot, links, random, 2, 2)
    moving = [f"torso_{n}_joint" for n in (1, 2)] + [f"arm_left_{n}_joint" for n in (1, 2, 3, 4)]
    joints = [robot.joint_index(name) for name in [*moving, "arm_right_1_joint", "arm_right_2_joint"]]
    recordings, rests = recorded(skin, swings_of(robot, joints, random, amplitude=0.08), random, IMPERFECT)
    estimate = estimate_kinematics(recordings, true_patches(skin), joint_names=robot.joint_names, rests=rests)
    found = {frozenset(robot.joint_names[estimate.joints[row]] for row in path): path for path in estimate.tree.paths}
    assert {frozenset(moving), frozenset([*moving[:2], "arm_right_1_joint", "arm_right_2_joint"])} <= set(found)
    assert len({path[:2] for path in found.values()}) == 1
    place, turn = cell_errors(estimate, skin, np.arange(len(skin.link)), random)
    assert place < 0.01
    assert turn < np.radians(0.6)


def test_two_arms_without_a_common_joint_do_not_know_of_each_other(seed: int) -> None:
    random = np.random.default_rng(seed)
    robot = load("dual_arm")
    links = [f"{side}_{link}" for side in ("left", "right") for link in ("upper_arm_link", "forearm_link")]
    skin = SimulatedSkin.of_sleeves(robot, links, random, 2, 2)
    joints = [index for index, name in enumerate(robot.joint_names) if any(p in name for p in ("shoulder", "elbow"))]
    recordings, rests = recorded(skin, swings_of(robot, joints, random), random, IMPERFECT)
    estimate = estimate_kinematics(recordings, true_patches(skin), joint_names=robot.joint_names, rests=rests)
    second = [one for one in estimate.unobservable if one.what.startswith("the arm that begins at")]
    assert len(second) == 4
    infinite = np.isinf(np.diagonal(estimate.covariance, axis1=1, axis2=2)[:, 3])
    carried = np.isin(estimate.patches.patch, second[0].patches)
    assert np.array_equal(infinite, carried)
    assert 0 < carried.sum() < len(carried)


class Valley:
    """A curved, narrow valley (Rosenbrock's) in place of a robot: a state is a point, its bottom lies at (1, 1)."""

    def __init__(self, steep: float) -> None:
        self.steep = steep

    def residual(self, state: np.ndarray) -> np.ndarray:
        return np.array([self.steep * (state[1] - state[0] ** 2), 10.0 * (1.0 - state[0])])

    def cost(self, state: np.ndarray, residual: np.ndarray, weights: np.ndarray) -> float:
        return 0.5 * float(weights @ residual**2)

    def linearise(self, state: np.ndarray, weights: np.ndarray) -> "Valley.Normal":
        jacobian = np.array([[2 * self.steep * state[0], -self.steep], [10.0, 0.0]])
        return self.Normal(jacobian.T @ jacobian, jacobian.T @ self.residual(state))

    def moved(self, state: np.ndarray, common: np.ndarray, own: np.ndarray) -> np.ndarray:
        return state + common

    def weights(self, residual: np.ndarray, factor: float) -> np.ndarray:
        return np.ones(2)

    def noise_factor(self, residual: np.ndarray) -> float:
        return 1.0

    class Normal:
        def __init__(self, matrix: np.ndarray, right: np.ndarray) -> None:
            self.matrix, self.right = matrix, right

        def step(self, damping: float) -> tuple[np.ndarray, np.ndarray]:
            scaled = self.matrix + damping * np.diag(self.matrix.diagonal())
            return np.linalg.solve(scaled, self.right), np.zeros(0)


def test_a_curved_valley_is_followed_to_its_end(seed: int) -> None:
    start = np.array([-1.5, 2.25]) + np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
    state, _, _, passes = settled(Valley(1000.0), start, least_gain=1e-6)  # type: ignore[arg-type]
    assert state == pytest.approx([1.0, 1.0], abs=1e-3)
    # Damping each refused step ten times as much takes 130 and more.
    assert passes < 110


def test_too_little_is_an_error(seed: int) -> None:
    random = np.random.default_rng(seed)
    skin = SimulatedSkin.of_sleeves(load("ur5"), ["forearm_link"], random, 2, 1)
    recordings, _ = recorded(skin, swings_of(skin.robot, [4], random), random, IMPERFECT)
    names = skin.robot.joint_names
    with pytest.raises(KinematicsError, match="moves any of the 2 cells"):
        estimate_kinematics(recordings, true_patches(skin), joint_names=names)
    with pytest.raises(KinematicsError, match="no recordings"):
        estimate_kinematics([], true_patches(skin), joint_names=names)
    with pytest.raises(ValueError, match="has 2 cells, the patches 3"):
        estimate_kinematics(recordings, RigidPatches.lone_cells(3), joint_names=names)
