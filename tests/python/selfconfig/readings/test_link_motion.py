# SPDX-License-Identifier: Apache-2.0
"""What a link feels while a joint swings, alone or among others, is what differences of its poses say."""

from dataclasses import dataclass

import numpy as np
import pytest

from robotskin.robots import Robot, load
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.readings.link_motion import LinkMotion, link_motions

LINKS = ("shoulder_link", "forearm_link", "wrist_3_link")
TIME_S = np.arange(0.0, 3.0, 0.004)
INSIDE = slice(50, -50)
STEP_S = 1e-4


@dataclass
class Swaying:
    """A UR5 whose joint 2 swings, while each of the others sways with 0.5 to 1.3 Hz."""

    robot: Robot
    swing: JointSine
    amplitude: np.ndarray
    frequency_hz: np.ndarray
    phase: np.ndarray

    def posture(self, time_s: np.ndarray) -> np.ndarray:
        angle = 2 * np.pi * self.frequency_hz * np.asarray(time_s)[:, None] + self.phase
        swayed = self.swing.centre + self.amplitude * np.sin(angle)
        swayed[:, self.swing.joint] = self.swing.posture(time_s)[:, self.swing.joint]
        return swayed

    def felt(self, link: str, point: np.ndarray) -> np.ndarray:
        """(M, 3) specific force at a point of a link, in its frame, by differences of the point's places."""
        row, up = self.robot.link_index(link), np.array([0.0, 0.0, GRAVITY_MPS2])
        poses = [
            np.array([self.robot.base_from_link(q)[row] for q in self.posture(TIME_S + k * STEP_S)]) for k in (-1, 0, 1)
        ]
        before, now, after = (pose[:, :3, :3] @ point + pose[:, :3, 3] for pose in poses)
        acceleration = (before - 2 * now + after) / STEP_S**2
        return np.einsum("mji,mj->mi", poses[1][:, :3, :3], acceleration + up)


@pytest.fixture
def swaying(seed: int) -> Swaying:
    random, robot = np.random.default_rng(seed), load("ur5")
    swing = JointSine(2, random.uniform(-1, 1, 6), 0.2, 1.0, 3.0)
    return Swaying(
        robot, swing, random.uniform(0.005, 0.01, 6), random.uniform(0.5, 1.3, 6), random.uniform(0, 2 * np.pi, 6)
    )


def at_point(motion: LinkMotion, point: np.ndarray) -> np.ndarray:
    return motion.specific_force + motion.tidal() @ point


@pytest.mark.parametrize("link", LINKS)
def test_a_link_feels_what_all_joints_do(swaying: Swaying, link: str, seed: int) -> None:
    point = np.random.default_rng(seed).uniform(-0.2, 0.2, 3)
    true = swaying.felt(link, point)[INSIDE]
    posture = swaying.posture(TIME_S)
    told = link_motions(swaying.robot, [link], swaying.swing, TIME_S, posture)[link]
    alone = link_motions(swaying.robot, [link], swaying.swing, TIME_S)[link]
    assert np.abs(at_point(told, point)[INSIDE] - true).max() < 5e-3
    assert np.abs(at_point(alone, point)[INSIDE] - true).max() > 0.02


def test_noise_of_encoders_hardly_counts(swaying: Swaying, seed: int) -> None:
    random = np.random.default_rng(seed)
    posture = swaying.posture(TIME_S)
    noisy = posture + random.normal(0.0, 2 * np.pi / 2**17, posture.shape)
    true, told = (
        link_motions(swaying.robot, ["forearm_link"], swaying.swing, TIME_S, q)["forearm_link"]
        for q in (posture, noisy)
    )
    assert np.abs(at_point(told, np.zeros(3)) - at_point(true, np.zeros(3)))[INSIDE].std() < 0.02


def test_joints_that_stay_change_nothing(swaying: Swaying) -> None:
    still = np.tile(swaying.swing.centre, (len(TIME_S), 1))
    told = link_motions(swaying.robot, LINKS, swaying.swing, TIME_S, still)
    for link, alone in link_motions(swaying.robot, LINKS, swaying.swing, TIME_S).items():
        for name in ("specific_force", "spin", "turning"):
            assert getattr(told[link], name) == pytest.approx(getattr(alone, name), abs=1e-6), (link, name)
