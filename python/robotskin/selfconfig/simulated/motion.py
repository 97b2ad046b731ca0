# SPDX-License-Identifier: Apache-2.0
"""What the cells of a robot feel while one joint swings: ground truth for benches and tests of what uses motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.babbling.joint_sine import JointSine
from robotskin.selfconfig.common.gravity import GRAVITY_MPS2
from robotskin.selfconfig.readings.link_motion import link_motions
from robotskin.selfconfig.readings.motion_recording import MotionRecording
from robotskin.selfconfig.simulated.limb import AccelerometerImperfections

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AccelerometerFaults:
    """The constant faults of N accelerometers.

    offset: (N, 3) m/s²; scale: (N, 3); slant: (N, 3, 3) what its axes show of those of its cell.
    """

    offset: Array
    scale: Array
    slant: Array

    @classmethod
    def draw(
        cls, random: np.random.Generator, count: int, imperfections: AccelerometerImperfections
    ) -> AccelerometerFaults:
        """Draw the faults of `count` accelerometers, the same in all their recordings."""
        return cls(
            random.uniform(-1, 1, (count, 3)) * imperfections.offset_mps2,
            1 + random.uniform(-1, 1, (count, 3)) * imperfections.scale,
            imperfections.slants(random, count),
        )


def swing_readings(
    robot: Robot,
    link: NDArray[np.integer],
    link_from_cell: Array,
    swing: JointSine,
    faults: AccelerometerFaults,
    random: np.random.Generator,
    imperfections: AccelerometerImperfections = AccelerometerImperfections(),  # noqa: B008 - frozen
    rate_hz: float = 250.0,
    meanwhile: Callable[[Array], Array] | None = None,
) -> MotionRecording:
    """What cells report while the robot follows a swing exactly.

    Args:
        robot: whose z axis of the base frame points up.
        link: (N,) index into `robot.link_names` of each cell's link.
        link_from_cell: (N, 4, 4) metres.
        swing: the motion.
        faults: of the accelerometers.
        random: draws the noise.
        imperfections: noise and quantisation step.
        rate_hz: of the samples.
        meanwhile: where the other joints are, (M, n) at times (M,); by default they stay.
    """
    time_s = np.arange(0.0, swing.duration_s, 1.0 / rate_hz)
    names = [robot.link_names[index] for index in np.unique(link)]
    posture = None if meanwhile is None else meanwhile(time_s)
    motions = link_motions(robot, names, swing, time_s, posture)
    felt = np.empty((len(link), len(time_s), 3))
    for name, motion in motions.items():
        there = link == robot.link_index(name)
        place, rotation = link_from_cell[there, :3, 3], link_from_cell[there, :3, :3]
        at_cell = motion.specific_force + np.einsum("mij,nj->nmi", motion.tidal(), place)
        felt[there] = at_cell @ rotation
    return MotionRecording(swing, time_s, _reported(felt, faults, random, imperfections), posture)


def rest_readings(
    robot: Robot,
    link: NDArray[np.integer],
    link_from_cell: Array,
    postures: Array,
    faults: AccelerometerFaults,
    random: np.random.Generator,
    imperfections: AccelerometerImperfections = AccelerometerImperfections(),  # noqa: B008 - frozen
    samples: int = 16,
) -> Array:
    """(N, K, samples, 3) m/s², what cells report while the robot rests in postures.

    Args:
        robot: whose z axis of the base frame points up.
        link: (N,) index into `robot.link_names` of each cell's link.
        link_from_cell: (N, 4, 4) metres.
        postures: (K, n) rad or m.
        faults: of the accelerometers.
        random: draws the noise.
        imperfections: noise and quantisation step.
        samples: of a rest.
    """
    up = np.stack([robot.base_from_link(posture)[link, 2, :3] for posture in postures], axis=1)
    felt = GRAVITY_MPS2 * np.einsum("nji,nkj->nki", link_from_cell[:, :3, :3], up)
    return _reported(np.repeat(felt[:, :, None], samples, axis=2), faults, random, imperfections)


def _reported(
    felt: Array, faults: AccelerometerFaults, random: np.random.Generator, imperfections: AccelerometerImperfections
) -> Array:
    """(N, ..., 3) m/s², what faulty, noisy and stepped accelerometers make of what is felt, of the same shape."""
    of_cell = (len(felt), *[1] * (felt.ndim - 2), 3)
    noise = random.standard_normal(felt.shape) * imperfections.noise_mps2
    seen = np.einsum("nij,n...j->n...i", faults.slant, felt, optimize=True)
    read = seen * faults.scale.reshape(of_cell) + faults.offset.reshape(of_cell) + noise
    return np.round(read / imperfections.step_mps2) * imperfections.step_mps2
