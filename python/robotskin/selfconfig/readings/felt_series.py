# SPDX-License-Identifier: Apache-2.0
"""Joints and accelerometers of any skin over time, as a table that others can write: in and out: a CSV.

A row is an instant. The first column is `time_s`, then one column a joint by its name (rad or m), then three a sensor:
`NAME_x`, `NAME_y`, `NAME_z`, its specific force in m/s² along its own axes. A sensor at rest reads 9.81 upward. What
was not read is left empty. Nothing tells where the sensors are; docs/selfconfig.md describes the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from robotskin.selfconfig.readings.number_table import NumberTable
from robotskin.selfconfig.readings.recording import RecordingError
from robotskin.whole_file import whole_file

Array = NDArray[np.float64]

TIME, AXES = "time_s", ("x", "y", "z")
MOST_STEP_S = 0.01
"""From row to row, in the median: rests and motions are told by what lies between."""


@dataclass(frozen=True, eq=False)
class FeltSeries:
    """T instants of n joints and N sensors.

    joint_names: (n). sensor_names: (N). time_s: (T,) rising. position: (T, n) rad or m. acceleration: (T, N, 3) m/s²,
    NaN where nothing was read.
    """

    joint_names: tuple[str, ...]
    sensor_names: tuple[str, ...]
    time_s: Array
    position: Array
    acceleration: Array

    @classmethod
    def load(cls, path: str | Path, joint_names: Sequence[str]) -> FeltSeries:
        """Read a CSV that has a column for each of the joints.

        Raises:
            RecordingError: no such table; a joint without a column, a sensor without its three; a row that was cut off,
                or a cell that is no number; times that do not rise, or in steps beyond `MOST_STEP_S`; a joint that was
                not read; fewer than two rows.
        """
        table = NumberTable.load(path)
        lacking = [name for name in (TIME, *joint_names) if name not in table.names]
        if lacking:
            columns = ", ".join(table.names[:8])
            raise RecordingError(
                f"{path}: no column {', '.join(lacking)}; it begins with {columns}. The columns are {TIME}, the joints "
                f"{', '.join(joint_names)}, and NAME_x, NAME_y, NAME_z of each sensor"
            )
        others = [name for name in table.names if name not in (TIME, *joint_names)]
        sensors = list(dict.fromkeys(name[:-2] for name in others if name[-2:] in ("_x", "_y", "_z")))
        wanted = [f"{name}_{axis}" for name in sensors for axis in AXES]
        if set(wanted) != set(others) or not sensors:
            odd = sorted(set(wanted) ^ set(others))
            raise RecordingError(f"{path}: {', '.join(odd) or 'no sensor'}: a sensor has NAME_x, NAME_y and NAME_z")
        values = table.numbers([TIME, *joint_names, *wanted])
        count = 1 + len(joint_names)
        time_s, position = values[:, 0], values[:, 1:count]
        table.require(
            TIME, np.isfinite(time_s) & np.r_[True, np.diff(time_s) > 0][: len(table)], "must be a number and rise"
        )
        for number, name in enumerate(joint_names):
            table.require(name, np.isfinite(position[:, number]), "must be a number in every row")
        if len(table) < 2:
            raise RecordingError(
                f"{path}: {len(table)} rows: a series has rests and motions of some seconds each; "
                "robotskin configure ROBOT --recording FILE.csv writes one of a simulated robot"
            )
        step_s = float(np.median(np.diff(time_s)))
        if step_s > MOST_STEP_S + 1e-6:
            raise RecordingError(
                f"{path}: {TIME}: steps of {1e3 * step_s:.3g} ms in the median: must be {1e3 * MOST_STEP_S:g} ms or "
                "less; record at 100 Hz or faster, times in seconds"
            )
        acceleration = values[:, count:].reshape(len(values), len(sensors), 3)
        return cls(tuple(joint_names), tuple(sensors), time_s, position, acceleration)

    def save(self, path: str | Path) -> None:
        """Write the CSV, whole or not at all; accelerations to 1 mm/s²."""
        names = [f"{sensor}_{axis}" for sensor in self.sensor_names for axis in AXES]
        felt = pd.DataFrame(self.acceleration.reshape(len(self.time_s), -1), columns=names)
        joints = pd.DataFrame(self.position, columns=list(self.joint_names)).map("{:.6f}".format)
        joints.insert(0, TIME, [f"{value:.4f}" for value in self.time_s])
        with whole_file(Path(path)) as partial:
            pd.concat([joints, felt], axis=1).to_csv(partial, index=False, float_format="%.3f")

    def keys(self) -> NDArray[np.int64]:
        """(N,) of each sensor: its name where all names are whole numbers, else its place among them, from 1."""
        if all(name.isdigit() for name in self.sensor_names):
            return np.array([int(name) for name in self.sensor_names], dtype=np.int64)
        return np.arange(1, len(self.sensor_names) + 1, dtype=np.int64)
