# SPDX-License-Identifier: Apache-2.0
"""A simulated skin in a process of its own: behind section units, or on serial lines."""

from __future__ import annotations

from pathlib import Path

from robotskin import layout as layouts
from robotskin import robots
from robotskin.keys import SkinKeys
from robotskin.rehearsal.process import Process, RehearsalError
from robotskin.rehearsal.serial_skin import SerialSkin
from robotskin.rehearsal.skin_units import SkinUnits
from robotskin.robots.gains import robot_with_gains


def make(
    robot: str, layout: str | None, key: str | None, controller: str, host: str, first_port: int, seed: int
) -> SkinUnits:
    """In the process that shall run it."""
    return SkinUnits(*_worn(robot, layout, key, seed), controller, host, first_port, seed)


def make_serial(
    robot: str, layout: str | None, key: str | None, folder: str, controller: str | None, seed: int
) -> SerialSkin:
    """In the process that shall run it."""
    return SerialSkin(*_worn(robot, layout, key, seed), folder, controller, seed)


def _worn(robot: str, layout: str | None, key: str | None, seed: int) -> tuple[robots.Robot, layouts.Layout, SkinKeys]:
    model = robot_with_gains(robot).robot
    worn = layouts.finished(model.name) if layout is None else layouts.Layout.load(layout)
    if not worn.section_unit_ports:
        raise RehearsalError(
            f"layout {layout}: no section unit is plugged into it, so no cell could be reached; leave it out, and give "
            "another maker's skin to robotskin connect: --skin FILE"
        )
    return model, worn, SkinKeys.of_seed(seed) if key is None else SkinKeys.load(key)


def skin(
    robot: str = "ur5",
    controller: str = "127.0.0.1",
    *,
    layout: str | Path | None = None,
    key: str | Path | None = None,
    host: str = "127.0.0.1",
    first_port: int = 0,
    seed: int = 1,
) -> Process:
    """Start the section units of a robot's skin, which follow a controller. Raises RehearsalError.

    Args:
        robot: by name or URDF.
        controller: address of a UR controller, or ros2:DOMAIN.
        layout: file of the skin's layout; by default the robot's finished one.
        key: file of the skin's keys; by default they come from the seed, which suits loopback alone.
        host, first_port: where the units answer.
        seed: of the skin.
    """
    return Process(
        make,
        robot=robot,
        layout=None if layout is None else str(layout),
        key=None if key is None else str(key),
        controller=controller,
        host=host,
        first_port=first_port,
        seed=seed,
    )


def serial_skin(
    robot: str = "ur5",
    folder: str | Path = "skin_lines",
    controller: str | None = None,
    *,
    layout: str | Path | None = None,
    key: str | Path | None = None,
    seed: int = 1,
) -> Process:
    """Start the cells of a robot's skin on pseudo-terminals in a folder. Raises RehearsalError.

    Args:
        robot, layout, key, seed: as of `skin`.
        folder: where the pseudo-terminals get names.
        controller: address of a UR controller that the skin follows, or ros2:DOMAIN; None: the robot stands.
    """
    return Process(
        make_serial,
        robot=robot,
        layout=None if layout is None else str(layout),
        key=None if key is None else str(key),
        folder=str(folder),
        controller=controller,
        seed=seed,
    )
