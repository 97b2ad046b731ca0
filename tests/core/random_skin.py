# SPDX-License-Identifier: Apache-2.0
"""A random skin on a robot, random touches and random postures."""

import numpy as np

from robotskin.model import RobotDynamics, RobotModel
from robotskin.skin import Health, SkinModel, SkinState


def random_skin(robot: RobotModel, cells: int, rng: np.random.Generator, grouped: bool = False) -> SkinModel:
    """Cells in random places on random links, the base among them."""
    link = rng.integers(0, robot.link_count, cells).astype(np.int32)
    pose = np.tile(np.eye(4), (cells, 1, 1))
    pose[:, :3, :3] = np.linalg.qr(rng.normal(size=(cells, 3, 3)))[0]
    pose[:, :3, 3] = rng.uniform(-0.1, 0.1, (cells, 3))
    return SkinModel(
        link_names=list(robot.link_names),
        key=np.arange(1, cells + 1, dtype=np.uint32),
        link=np.sort(link) if grouped else link,
        link_from_cell=pose,
        neighbours=np.tile(np.array([-1, 0], dtype=np.int32), (cells, 4, 1)),
        patch=(np.arange(cells) % 3).astype(np.int32) - 1,
    )


def random_state(cells: int, rng: np.random.Generator) -> SkinState:
    """Every cell alive and touched."""
    state = SkinState(cells)
    state.health[:] = Health.alive.value
    state.normal_force[:] = rng.uniform(0, 5, (cells, 3))
    state.proximity[:] = rng.uniform(0, 1, cells)
    return state


def at_random_posture(robot: RobotModel, rng: np.random.Generator) -> RobotDynamics:
    dynamics = RobotDynamics(robot)
    dynamics.update(*random_posture(robot, rng))
    return dynamics


def random_posture(robot: RobotModel, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    low, high = np.maximum(robot.lower, -3), np.minimum(robot.upper, 3)
    return rng.uniform(low, high), rng.uniform(-0.5, 0.5, robot.joint_count)
