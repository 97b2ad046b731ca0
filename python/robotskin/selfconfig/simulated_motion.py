"""What the cells of a robot feel while one joint swings: ground truth for benches and tests of what uses motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robotskin.robots import Robot
from robotskin.selfconfig.gravity_samples import GRAVITY_MPS2
from robotskin.selfconfig.joint_sine import JointSine
from robotskin.selfconfig.simulated_limb import AccelerometerImperfections

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MotionRecording:
    """One swing of one joint as N cells felt it at M instants.

    swing: what was commanded; time_s: (M,) since its start; acceleration: (N, M, 3) m/s² specific force, cell frame.
    """

    swing: JointSine
    time_s: Array
    acceleration: Array


@dataclass(frozen=True, eq=False)
class AccelerometerFaults:
    """The constant faults of N accelerometers: offset (N, 3) m/s², scale (N, 3)."""

    offset: Array
    scale: Array

    @classmethod
    def draw(
        cls, random: np.random.Generator, count: int, imperfections: AccelerometerImperfections
    ) -> AccelerometerFaults:
        """Draw the faults of `count` accelerometers, the same in all their recordings."""
        return cls(
            random.uniform(-1, 1, (count, 3)) * imperfections.offset_mps2,
            1 + random.uniform(-1, 1, (count, 3)) * imperfections.scale,
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
    """
    model, data = robot.model, robot.model.createData()
    time_s = np.arange(0.0, swing.duration_s, 1.0 / rate_hz)
    posture = swing.posture(time_s)
    rate = np.zeros_like(posture)
    rate[:, swing.joint] = swing.displacement(time_s, 1)
    acceleration = np.zeros_like(posture)
    acceleration[:, swing.joint] = swing.displacement(time_s, 2)
    used = np.unique(link)
    frames = [model.getBodyId(robot.link_names[index]) for index in used]
    slot = np.searchsorted(used, link)
    felt = np.empty((len(link), len(time_s), 3))
    place = link_from_cell[:, :3, 3]
    up = np.array([0.0, 0.0, GRAVITY_MPS2])
    for instant in range(len(time_s)):
        pinocchio.forwardKinematics(model, data, posture[instant], rate[instant], acceleration[instant])
        linear, angular, turning = (np.empty((len(used), 3)) for _ in range(3))
        for number, frame in enumerate(frames):
            placement = pinocchio.updateFramePlacement(model, data, frame)
            motion = pinocchio.getFrameClassicalAcceleration(model, data, frame, pinocchio.LOCAL)
            linear[number] = motion.linear + placement.rotation.T @ up
            angular[number] = motion.angular
            turning[number] = pinocchio.getFrameVelocity(model, data, frame, pinocchio.LOCAL).angular
        spin = turning[slot]
        at_cell = linear[slot] + np.cross(angular[slot], place) + np.cross(spin, np.cross(spin, place))
        felt[:, instant] = np.einsum("nji,nj->ni", link_from_cell[:, :3, :3], at_cell)
    felt = felt * faults.scale[:, None] + faults.offset[:, None]
    felt += random.standard_normal(felt.shape) * imperfections.noise_mps2
    return MotionRecording(swing, time_s, np.round(felt / imperfections.step_mps2) * imperfections.step_mps2)
