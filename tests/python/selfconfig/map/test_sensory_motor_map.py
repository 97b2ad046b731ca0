# SPDX-License-Identifier: Apache-2.0
import io
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robotskin.errors import UnknownNameError
from robotskin.robots import load
from robotskin.selfconfig.babbling.joint_sine import JointSine, VelocitySine
from robotskin.selfconfig.map.map_picture import save_map_picture
from robotskin.selfconfig.map.sensory_motor_map import (
    SensoryMotorMap,
    SensoryMotorMapError,
    build_map,
    sign_agreement,
    weights,
)
from robotskin.selfconfig.readings.expected_motion import gravity_while_swinging, normal_jacobian
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections
from robotskin.selfconfig.simulated.motion import AccelerometerFaults, swing_readings

IMPERFECT = AccelerometerImperfections()
LINKS = ["upper_arm_link", "forearm_link", "wrist_2_link"]


def swings(seed: int, kind: type[JointSine] = JointSine, amplitude: float = 0.16, duration_s: float = 3.0) -> tuple:
    """UR5 with eight cells a link, 15 cm off its frame's origin; every joint swings in two postures."""
    random = np.random.default_rng(seed)
    robot = load("ur5")
    link = np.repeat([robot.link_index(name) for name in LINKS], 8)
    pose = np.tile(np.eye(4), (len(link), 1, 1))
    pose[:, :3, :3] = Rotation.random(len(link), random).as_matrix()
    way = random.standard_normal((len(link), 3))
    pose[:, :3, 3] = 0.15 * way / np.linalg.norm(way, axis=1, keepdims=True)
    faults = AccelerometerFaults.draw(random, len(link), IMPERFECT)
    recordings = [
        swing_readings(robot, link, pose, kind(joint, centre, amplitude, 1.0, duration_s), faults, random)
        for centre in random.uniform(-1.5, 1.5, (2, 6))
        for joint in range(6)
    ]
    gravity = [gravity_while_swinging(robot, link, pose, one.swing, one.time_s) for one in recordings]
    moved = np.abs(np.array([normal_jacobian(robot, link, pose, q) for q in np.eye(6)])).max(axis=0).T > 1e-9
    return robot, link, pose, recordings, gravity, moved


def test_jacobian_along_the_normal_is_the_derivative_of_the_place(seed: int) -> None:
    robot, link, pose, recordings, _, _ = swings(seed)
    posture, step = recordings[0].swing.centre, 1e-6
    jacobian = normal_jacobian(robot, link, pose, posture)
    normal = (robot.base_from_link(posture)[link] @ pose)[:, :3, 2]
    for joint in range(6):
        ahead, behind = posture.copy(), posture.copy()
        ahead[joint] += step
        behind[joint] -= step
        way = robot.base_from_link(ahead)[link] @ pose - robot.base_from_link(behind)[link] @ pose
        assert np.allclose(np.einsum("ni,ni->n", way[:, :3, 3] / (2 * step), normal), jacobian[:, joint], atol=1e-6)


def test_gravity_alone_is_what_a_motion_without_speed_would_feel(seed: int) -> None:
    robot, link, pose, recordings, gravity, _ = swings(seed)
    recording = recordings[1]
    for instant in (30, 300):
        base_from_cell = robot.base_from_link(recording.swing.posture(recording.time_s)[instant])[link] @ pose
        assert np.allclose(gravity[1][:, instant], 9.80665 * base_from_cell[:, 2, :3], atol=1e-3)


def test_signs_are_those_of_the_jacobian_and_the_papers_rule_on_one_velocity_sine_is_chance(seed: int) -> None:
    robot, link, pose, recordings, gravity, moved = swings(seed)
    names, cell = robot.joint_names, np.arange(len(link))
    ours = build_map(
        robot.name,
        names,
        cell,
        recordings,
        moved,
        lambda one: gravity[recordings.index(one)],
        suppression=0.0,
        normalise=False,
    )
    true = np.array([normal_jacobian(robot, link, pose, posture) for posture in ours.posture])
    assert sign_agreement(ours.weight, true) >= 0.99
    robot, link, pose, recordings, _, moved = swings(seed, VelocitySine, 0.3, 1.0)
    papers = build_map(robot.name, names, cell, recordings, moved, sign="first extremum", suppression=0.0)
    assert 0.25 < sign_agreement(papers.weight, true) < 0.75


def test_a_weight_is_one_along_the_motion_and_none_across(seed: int) -> None:
    time_s = np.arange(750) / 250
    swing = JointSine(0, np.zeros(1), 0.1, 1.0, 3.0)
    felt = np.zeros((3, 750, 3))
    felt[0, :, 2] = swing.displacement(time_s, 2)
    felt[1, :, 0] = swing.displacement(time_s, 2)
    felt[2] = -swing.displacement(time_s, 2)[:, None]
    felt += np.array([0.3, -0.2, 9.8])
    found = weights(MotionRecording(swing, time_s, felt))
    assert np.allclose(found, [1.0, 0.0, -1 / 3], atol=1e-6)


def test_masked_suppressed_normalised_and_recalled_by_the_nearest_posture(seed: int, tmp_path: Path) -> None:
    robot, link, _, recordings, gravity, moved = swings(seed)
    cell = np.arange(len(link)) + 7
    learned = build_map(
        robot.name,
        robot.joint_names,
        cell,
        recordings,
        moved,
        lambda one: gravity[recordings.index(one)],
        suppression=0.3,
    )
    assert np.all(learned.weight[:, ~moved.T] == 0)
    length = np.linalg.norm(learned.weight, axis=2)
    assert np.all(np.isclose(length, 1.0) | (length == 0))
    posture = learned.posture[1] + 0.1
    assert learned.nearest(posture) == 1
    assert np.array_equal(learned.recall(posture), learned.weight[1])
    touched = np.zeros(len(cell))
    touched[5] = 2.0
    assert np.allclose(learned.reaction(posture, touched), -2.0 * learned.weight[1, 5])
    learned.save(tmp_path / "map.npz")
    again = SensoryMotorMap.load(tmp_path / "map.npz")
    assert np.array_equal(again.weight, learned.weight)
    assert np.array_equal(again.posture, learned.posture)
    assert (again.robot, again.joint_names) == (learned.robot, learned.joint_names)
    save_map_picture(again, tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 5000


def test_gaps_in_the_readings_hardly_change_a_weight_and_a_dead_cell_has_none(seed: int) -> None:
    _, _, _, recordings, gravity, _ = swings(seed)
    recording = recordings[1]
    felt = recording.acceleration.copy()
    felt[3, ::9] = np.nan
    felt[4] = np.nan
    whole = weights(recording, gravity[1])
    holed = weights(MotionRecording(recording.swing, recording.time_s, felt), gravity[1])
    assert abs(whole[3] - holed[3]) < 0.05
    assert holed[4] == 0


def test_what_makes_no_map_is_refused(tmp_path: Path, seed: int) -> None:
    _, _, _, recordings, _, moved = swings(seed)
    with pytest.raises(UnknownNameError, match="correlation"):
        weights(recordings[0], sign="loudest")  # type: ignore[arg-type]
    with pytest.raises(SensoryMotorMapError, match="above 10"):
        weights(recordings[0], bandwidth_over_pattern=10.0)
    with pytest.raises(SensoryMotorMapError, match="no swings"):
        build_map("ur5", "abcdef", np.arange(24), [], moved)
    with pytest.raises(SensoryMotorMapError, match="activity"):
        build_map("ur5", "abcdef", np.arange(24), recordings, moved[:, :3])
    with pytest.raises(SensoryMotorMapError, match="weight holds nan"):
        SensoryMotorMap("arm", ("a",), np.array([1]), np.zeros((1, 1)), np.full((1, 1, 1), np.nan))


def test_a_file_that_holds_no_map_is_refused_by_name_and_by_what_would_be_one(tmp_path: Path) -> None:
    learned = SensoryMotorMap("arm", ("a", "b"), np.array([1, 2]), np.zeros((1, 2)), np.ones((1, 2, 2)))
    file = tmp_path / "file.npz"
    learned.save(file)
    whole = file.read_bytes()
    arrays = dict(np.load(file))
    np.save(tmp_path / "single.npy", np.zeros(3))

    def refused(content: bytes, message: str) -> None:
        file.write_bytes(content)
        with pytest.raises(SensoryMotorMapError, match=message) as error:
            SensoryMotorMap.load(file)
        assert "file.npz: " in str(error.value)
        assert "allow_pickle" not in str(error.value)

    for content in (b"", b"# a text\n", whole[: len(whole) // 2], (tmp_path / "single.npy").read_bytes()):
        refused(content, "no whole numpy archive .*robotskin configure --map FILE")

    def archive(**changed: object) -> bytes:
        content = io.BytesIO()
        np.savez(content, **{name: value for name, value in {**arrays, **changed}.items() if value is not None})
        return content.getvalue()

    refused(archive(format="robotskin-babbling"), "format 'robotskin-babbling' version 1: must be .* --map FILE")
    refused(archive(version=2), "version 2: must be")
    refused(archive(weight=None), "array 'weight' is missing")
    refused(archive(posture=np.zeros((1, 3))), "posture .1, 3.: must be")
    refused(archive(weight=np.full((1, 2, 2), np.inf)), "weight holds inf")
    refused(archive(weight=np.full((1, 2, 2), "one")), "file.npz")
