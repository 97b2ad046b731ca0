# SPDX-License-Identifier: Apache-2.0
"""How far off the zero-moment point of cells in the soles is, and that of a linear map of the same cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.balance.insole import LEAST_N, Insole
from robotskin.apps.balance.sole_port import SolePort
from robotskin.model import RobotPort
from robotskin.robots import Robot
from robotskin.world import World

Array = NDArray[np.float64]
BLIND_M = 0.22
"""A sole's length: so far off counts a sample in which the cells feel no load though the robot stands."""


class LinearMap:
    """The baseline: (3,) newton and newton metres, as of the calibration, by a linear map that learnt from the same
    poses."""

    def __init__(self, insole: Insole) -> None:
        felt, loads, centres = insole.poses
        # Ridge for sensors that nearly agree.
        a = np.column_stack([felt, np.ones(len(loads))])
        b = loads[:, None] * np.column_stack([np.ones(len(loads)), centres])
        self._linear = np.linalg.solve(a.T @ a + 1e-3 * np.eye(a.shape[1]), a.T @ b).T

    def load(self, felt: Array) -> Array:
        """Of what (n,) sensors feel."""
        return np.asarray(self._linear @ np.append(felt, 1.0))


class ComparedSolePort(SolePort):
    """A port of soles that keeps how far it is off."""

    def __init__(self, world: World, robot: Robot, port: RobotPort, cells: int, seed: int) -> None:
        super().__init__(world, robot, port, cells, seed)
        self._linear = [LinearMap(side.insole) for side in self.sides]
        self.errors_m: list[float] = []
        """Between the true zero-moment point and that of the soles, at each sample; then that of the linear map."""
        self.linear_errors_m: list[float] = []

    def _sampled(self, true: Sequence[tuple[float, Array]], felt: Sequence[Array], told: Array) -> None:
        true_loads = np.array([[load, *(load * centre)] for load, centre in true])
        if true_loads[:, 0].sum() <= LEAST_N:
            return
        poses = [self.world.scene.data.body(side.foot.link) for side in self.sides]
        turns = [pose.xmat.reshape(3, 3)[:2, :2] for pose in poses]
        middles = [
            pose.xpos[:2] + turn @ np.array(side.foot.sole_m[:2])
            for pose, turn, side in zip(poses, turns, self.sides, strict=True)
        ]
        linear = np.array([one.load(shown) for one, shown in zip(self._linear, felt, strict=True)])
        point = _pressed_at(true_loads, middles, turns)
        for found, errors_m in ((told, self.errors_m), (linear, self.linear_errors_m)):
            felt_all = found[:, 0].sum() > LEAST_N
            off = np.linalg.norm(_pressed_at(found, middles, turns) - point) if felt_all else BLIND_M
            errors_m.append(float(off))


def _pressed_at(loads: Array, middles: list[Array], turns: list[Array]) -> Array:
    """(2,) of the floor: where both soles' loads (2, 3) press together; middles (2,) and turns (2, 2) of each sole."""
    moments = [load[0] * middle + turn @ load[1:] for load, middle, turn in zip(loads, middles, turns, strict=True)]
    return np.asarray(sum(moments) / loads[:, 0].sum())
