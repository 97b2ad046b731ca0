# SPDX-License-Identifier: Apache-2.0
"""Joints and accelerometers of a whole exploration as a series, such as others record of their robots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin.configuring.exploration import PERIOD_S, SAMPLE_PERIOD_S, SENSOR_DELAY_S, Exploration, on_grid
from robotskin.model import JointCommand, JointState
from robotskin.selfconfig.readings.felt_series import FeltSeries


class KeptSeries:
    """Listens to an exploration from `begin` on; nothing is told of rests, swings and what was commanded."""

    def __init__(self) -> None:
        self._ticks = 0
        self._begin_ns = 0
        self._stamp: list[NDArray[np.int64]] = []
        self._counts: list[NDArray[np.int16]] = []
        self._time_ns: list[int] = []
        self._position: list[NDArray[np.float64]] = []

    def begin(self, exploration: Exploration) -> None:
        """Listen from now on, beside whatever listens already."""
        self._exploration, self._before = exploration, exploration.moved
        self._begin_ns = exploration.world.now_ns
        exploration.moved = self._moved

    def _moved(self, now_ns: int, joints: JointState, command: JointCommand | None) -> None:
        if self._before is not None:
            self._before(now_ns, joints, command)
        self._ticks += 1
        if self._ticks % round(SAMPLE_PERIOD_S / PERIOD_S):
            return
        samples = self._exploration.driver.samples()
        self._stamp.append(np.array(samples["stamp_ns"], dtype=np.int64))
        self._counts.append(np.array(samples["acceleration"], dtype=np.int16))
        self._time_ns.append(joints.stamp_ns)
        self._position.append(np.array(joints.position))

    def series(self, every: int = 2) -> FeltSeries:
        """What was felt, each so many sample periods."""
        time_s = (np.array(self._time_ns) - self._begin_ns) * 1e-9
        stamps = np.asarray((np.array(self._stamp) - self._begin_ns) * 1e-9 - SENSOR_DELAY_S, dtype=np.float64)
        grid, felt = on_grid(stamps, np.array(self._counts), float(time_s[-1]))
        position = np.array(self._position)
        at = np.column_stack([np.interp(grid, time_s, column) for column in position.T])
        return FeltSeries(
            self._exploration.robot.joint_names,
            tuple(str(int(key)) for key in self._exploration.keys),
            grid[::every],
            at[::every],
            felt.swapaxes(0, 1)[::every],
        )
