# SPDX-License-Identifier: Apache-2.0
"""Presses as a table (CSV): one row a moment; of each cell first some rows at rest, then presses in and out.

Columns: cell (index in the layout), touching (0 or 1), x_mm, y_mm (place on the cell's face), shown_1_n, shown_2_n,
shown_3_n. Of a probe: force_n. Of a robot, for each joint NAME: NAME_rad, NAME_rad_s, NAME_nm.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotskin.calibration.errors import CalibrationError
from robotskin.calibration.force_sensors import Array
from robotskin.calibration.post import Levers
from robotskin.calibration.presses import Presses
from robotskin.layout import Layout
from robotskin.robots import Robot

COLUMNS = ("cell", "touching", "x_mm", "y_mm", "shown_1_n", "shown_2_n", "shown_3_n")
STILL_RAD_S = 1e-4


def read_presses(file: Path, robot: Robot, layout: Layout) -> list[Presses]:
    """The presses of a table. Raises CalibrationError, which names the column, the line or the cell."""
    try:
        with file.open(newline="", encoding="utf-8") as text:
            reader = csv.DictReader(text)
            names = list(reader.fieldnames or [])
            rows = [[float(value) for value in row.values()] for row in reader]
    except (OSError, ValueError, TypeError) as error:
        raise CalibrationError(f"{file}: {error}") from error
    by_probe = "force_n" in names
    joints = [f"{name}{unit}" for unit in ("_rad", "_rad_s", "_nm") for name in robot.joint_names]
    missing = [name for name in (*COLUMNS, *(["force_n"] if by_probe else joints)) if name not in names]
    if missing:
        raise CalibrationError(
            f"{file}: no column {missing[0]}; needed are {', '.join(COLUMNS)} and force_n or {joints[0]} …"
        )
    if not rows or not np.isfinite(rows).all():
        raise CalibrationError(f"{file}: it has no rows, or a value that is not finite")
    table = dict(zip(names, np.array(rows).T, strict=True))
    cells = table["cell"].astype(int)
    wrong = cells[(cells < 0) | (cells >= len(layout))]
    if len(wrong):
        raise CalibrationError(f"{file}: cell {wrong[0]}: there are cells 0 to {len(layout) - 1}")
    levers = Levers(robot, layout)
    found = []
    for cell in np.unique(cells):
        own = {name: values[cells == cell] for name, values in table.items()}
        touching = own["touching"] > 0
        if touching.all() or not touching.any():
            raise CalibrationError(f"{file}: cell {cell}: it needs rows at rest and rows of presses")
        found.append(_of_cell(int(cell), own, touching, robot, layout, levers, by_probe))
    return found


def _of_cell(
    cell: int,
    table: dict[str, Array],
    touching: NDArray[np.bool_],
    robot: Robot,
    layout: Layout,
    levers: Levers,
    by_probe: bool,
) -> Presses:
    shown = np.stack([table[f"shown_{sensor}_n"] for sensor in (1, 2, 3)], axis=1)
    reference: dict[str, Array] = {}
    if by_probe:
        reference["force_n"] = table["force_n"][touching]
    else:
        position, velocity, torque = (
            np.stack([table[f"{name}{unit}"] for name in robot.joint_names], axis=1)
            for unit in ("_rad", "_rad_s", "_nm")
        )
        reference["torque_nm"] = (torque - torque[~touching].mean(axis=0))[touching]
        reference["lever_nm_per_n"] = np.array([levers.at(q)[0][cell] for q in position[touching]])
        reference["direction"] = np.where(np.abs(velocity) < STILL_RAD_S, 0.0, np.sign(velocity))[touching]
    return Presses(
        cell=cell,
        neighbours=int((layout.neighbours[cell, :, 0] >= 0).sum()),
        rest_n=shown[~touching].mean(axis=0),
        reading_n=shown[touching],
        place_m=np.stack([table["x_mm"], table["y_mm"]], axis=1)[touching] / 1000,
        carried_n=np.full(int(touching.sum()), np.nan),
        **reference,
    )
