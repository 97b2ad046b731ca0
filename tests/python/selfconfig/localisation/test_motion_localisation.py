# SPDX-License-Identifier: Apache-2.0
"""Laws of localisation from motion: link and place are found, what is open is named, what contradicts is left out."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robotskin.robots import Robot, load
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.common.prior_knowledge import PriorKnowledge
from robotskin.selfconfig.localisation.localisation import Localisation, LocalisationError, pose_error
from robotskin.selfconfig.localisation.motion_fit import FitState, MotionFit
from robotskin.selfconfig.localisation.motion_localisation import localise_by_motion, motion_signals
from robotskin.selfconfig.readings.gravity_samples import GravitySamples
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections, forearm_patch
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, swing_readings

IMPERFECT = AccelerometerImperfections()


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("ur5")


def random_pose(random: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=random).as_matrix()
    pose[:3, 3] = random.uniform(-0.15, 0.15, 3)
    return pose


def swings(robot: Robot, random: np.random.Generator, joints: list[int], postures: int = 3) -> list[JointSine]:
    centres = random.uniform(-1.5, 1.5, (postures, robot.joint_count))
    return [JointSine(joint, centre, 0.2, 1.0, 3.0) for centre in centres for joint in joints]


def record(
    robot: Robot, link: str, poses: np.ndarray, motions: list[JointSine], random: np.random.Generator
) -> list[MotionRecording]:
    faults = AccelerometerFaults.draw(random, len(poses), IMPERFECT)
    carrier = np.full(len(poses), robot.link_index(link))
    return [swing_readings(robot, carrier, poses, motion, faults, random, rate_hz=125.0) for motion in motions]


LONE = np.eye(4)[None]


@pytest.mark.parametrize("link", ["upper_arm_link", "forearm_link", "wrist_1_link", "wrist_3_link"])
def test_a_lone_cell_is_found_where_it_sits(robot: Robot, link: str, seed: int) -> None:
    random = np.random.default_rng(seed)
    true = random_pose(random)
    recordings = record(robot, link, true[None], swings(robot, random, list(range(6))), random)
    found = localise_by_motion(robot, recordings, LONE)
    assert link in (found.link, *found.same_link)
    assert found.open == ()
    error = pose_error(found.link_from_patch, true)
    assert error @ np.linalg.solve(found.covariance, error) < 33.0  # chi-square of six, one false alarm in 10⁵
    assert found.deviation()[0] < np.radians(1.2)
    assert found.deviation()[1] < 5e-3
    assert found.misfit == pytest.approx(1.0, abs=0.03)


def test_links_that_move_as_one_are_named_together(robot: Robot, seed: int) -> None:
    random = np.random.default_rng(seed)
    recordings = record(robot, "wrist_3_link", random_pose(random)[None], swings(robot, random, [4, 5]), random)
    found = localise_by_motion(robot, recordings, LONE)
    assert {found.link, *found.same_link} >= {"wrist_3_link", "ee_link", "tool0"}


EXACT_ROBOT = PriorKnowledge(link_shift_m=0.0, link_turn_rad=0.0)
"""What the model gets wrong is common to a patch and to its cells, and would hide what they differ by."""


def test_a_rigid_patch_is_found_better_than_its_cells(robot: Robot, seed: int) -> None:
    random = np.random.default_rng(seed)
    patch = forearm_patch(random, columns=3, rows=3)
    true, shape = random_pose(random), patch.root_from_cell(4)
    recordings = record(robot, "forearm_link", true @ shape, swings(robot, random, list(range(6))), random)
    signals = motion_signals(robot, recordings, prior=EXACT_ROBOT)
    whole = localise_by_motion(robot, recordings, shape, signals=signals)
    lone = localise_by_motion(robot, recordings, LONE, cells=np.array([4]), signals=signals)
    assert whole.used.all()
    assert whole.deviation()[0] < 0.5 * lone.deviation()[0]
    error = pose_error(whole.link_from_patch, true)
    assert error @ np.linalg.solve(whole.covariance, error) < 33.0


def first_link(robot: Robot, seed: int) -> tuple[Localisation, Callable[[float, float], np.ndarray]]:
    """A patch on the link that only a vertical axis moves; also its pose after a turn about and a slide along it."""
    random = np.random.default_rng(seed)
    patch = forearm_patch(random, columns=3, rows=3)
    true, shape = random_pose(random), patch.root_from_cell(4)
    recordings = record(robot, "shoulder_link", true @ shape, swings(robot, random, [0, 1, 2]), random)
    found = localise_by_motion(robot, recordings, shape)

    def screwed(turn: float, slide: float) -> np.ndarray:
        screw = np.eye(4)
        screw[:3, :3] = Rotation.from_rotvec([0, 0, turn]).as_matrix()
        screw[2, 3] = slide
        return screw @ true

    return found, screwed


def test_what_a_vertical_axis_leaves_open_is_named_and_infinite(robot: Robot, seed: int) -> None:
    found, screwed = first_link(robot, seed)
    assert found.link == "shoulder_link"
    assert [part.name for part in found.open] == ["angle about shoulder_pan_joint", "place along shoulder_pan_joint"]
    assert np.isinf(found.covariance[5, 5])
    assert not np.isnan(found.covariance).any()
    assert found.deviation() == (np.inf, np.inf)
    # The open motions are the joint's own screws, wherever along them the truth may be.
    errors = [found.aligned_errors(screwed(turn, slide)) for turn, slide in ((0, 0), (2.5, -0.3), (-1.0, 0.2))]
    assert errors[1] == pytest.approx(errors[0], rel=1e-3, abs=1e-6)
    assert errors[2] == pytest.approx(errors[0], rel=1e-3, abs=1e-6)
    assert errors[0][0] < np.radians(3.0)  # Tilt is told from an unknown offset by averaging over nine cells only.
    assert errors[0][1] < 5e-3


def test_a_direction_that_nothing_tells_is_open_and_no_error(
    robot: Robot, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its row of the information is zero to the last bit, as on a link of a humanoid that hardly swings."""
    random = np.random.default_rng(seed)
    recordings = record(robot, "forearm_link", random_pose(random)[None], swings(robot, random, list(range(6))), random)
    normal_of = MotionFit._normal

    def blind(fit: MotionFit, state: FitState, frozen_rotation: bool = False):
        normal = normal_of(fit, state, frozen_rotation)
        pose, cross, gradient = normal.pose.copy(), normal.cross.copy(), normal.pose_gradient.copy()
        pose[5] = pose[:, 5] = cross[..., 5] = gradient[5] = 0.0
        return dataclasses.replace(normal, pose=pose, cross=cross, pose_gradient=gradient)

    monkeypatch.setattr(MotionFit, "_normal", blind)
    assert localise_by_motion(robot, recordings, LONE).open


def test_rests_alone_add_to_what_swings_tell(robot: Robot, seed: int) -> None:
    random = np.random.default_rng(seed)
    true = random_pose(random)
    faults = AccelerometerFaults.draw(random, 1, IMPERFECT)
    link = np.array([robot.link_index("forearm_link")])
    motions = swings(robot, random, list(range(6)), postures=1)
    recordings = [swing_readings(robot, link, true[None], motion, faults, random) for motion in motions]
    postures = random.uniform(-1.5, 1.5, (8, 6))
    up = np.array([robot.base_from_link(posture)[link[0], 2, :3] for posture in postures])
    felt = (GRAVITY_MPS2 * up @ true[:3, :3]) * faults.scale[0] + faults.offset[0]
    raw = felt[None, :, None] + random.standard_normal((1, 8, 16, 3)) * IMPERFECT.noise_mps2
    without = localise_by_motion(robot, recordings, LONE)
    together = localise_by_motion(robot, recordings, LONE, rest_posture=postures, rest=GravitySamples.from_raw(raw))
    assert together.deviation()[0] < without.deviation()[0]
    error = pose_error(together.link_from_patch, true)
    assert error @ np.linalg.solve(together.covariance, error) < 33.0


def test_dead_and_displaced_cells_are_left_out_by_name(robot: Robot, seed: int) -> None:
    random = np.random.default_rng(seed)
    patch = forearm_patch(random, columns=3, rows=3)
    true, shape = random_pose(random), patch.root_from_cell(4)
    poses = true @ shape
    poses[7, :3, 3] += [0.0, 0.03, 0.0]
    recordings = record(robot, "forearm_link", poses, swings(robot, random, list(range(6))), random)
    for recording in recordings:
        recording.acceleration[2] = np.nan
        recording.acceleration[5, ::9] = np.nan
    found = localise_by_motion(robot, recordings, shape)
    assert np.flatnonzero(~found.used).tolist() == [2, 7]
    error = pose_error(found.link_from_patch, true)
    assert error @ np.linalg.solve(found.covariance, error) < 33.0


def test_what_cannot_be_answered_is_an_error(robot: Robot, seed: int) -> None:
    random = np.random.default_rng(seed)
    pose = random_pose(random)[None]
    still = record(robot, "shoulder_link", pose, swings(robot, random, [4, 5], postures=1), random)
    with pytest.raises(LocalisationError, match="no swing moved the patch"):
        localise_by_motion(robot, still, LONE)
    with pytest.raises(LocalisationError, match="no swings"):
        localise_by_motion(robot, [], LONE)
    with pytest.raises(LocalisationError, match="shape of 2 cells for 1"):
        localise_by_motion(robot, still, np.tile(np.eye(4), (2, 1, 1)))
    with pytest.raises(LocalisationError, match="none of the links"):
        localise_by_motion(robot, still, LONE, links=["shoulder_link"])


def test_a_base_that_sways_is_taken_off_where_it_was_measured(robot: Robot, seed: int) -> None:
    random = np.random.default_rng(seed)
    true = random_pose(random)
    faults = AccelerometerFaults.draw(random, 1, IMPERFECT)
    carrier = np.array([robot.link_index("wrist_1_link")])

    answer = random.uniform(0.02, 0.04, robot.joint_count) * random.choice([-1, 1], robot.joint_count)

    def swayed(motion: JointSine) -> MotionRecording:
        sways = (np.arange(robot.joint_count) < 3) & (np.arange(robot.joint_count) != motion.joint)

        def meanwhile(time_s: np.ndarray) -> np.ndarray:
            moved = motion.posture(time_s)
            moved[:, sways] += answer[sways] * motion.displacement(time_s)[:, None]
            return moved

        return swing_readings(robot, carrier, true[None], motion, faults, random, rate_hz=125.0, meanwhile=meanwhile)

    recordings = [swayed(motion) for motion in swings(robot, random, list(range(6)))]
    half_step = np.pi / 2**17
    noise = [random.uniform(-half_step, half_step, (len(one.time_s), robot.joint_count)) for one in recordings]
    measured = [
        dataclasses.replace(one, posture=one.posture + error) for one, error in zip(recordings, noise, strict=True)
    ]
    unknown = [dataclasses.replace(one, posture=None) for one in recordings]
    told, alone = (localise_by_motion(robot, one, LONE) for one in (measured, unknown))
    right, wrong = (pose_error(found.link_from_patch, true) for found in (told, alone))
    assert right @ np.linalg.solve(told.covariance, right) < 33.0
    assert wrong @ np.linalg.solve(alone.covariance, wrong) > 15.0
    assert told.misfit == pytest.approx(1.0, abs=0.05)
