# SPDX-License-Identifier: Apache-2.0
"""Section units of a simulated skin in a process of their own."""

from __future__ import annotations

from pathlib import Path

from robotskin import layout as layouts
from robotskin import robots
from robotskin.keys import SkinKeys
from robotskin.rehearsal.process import Process
from robotskin.rehearsal.skin_units import SkinUnits


def make(
    robot: str, layout: str | None, key: str | None, controller: str, host: str, first_port: int, seed: int
) -> SkinUnits:
    """In the process that shall run it."""
    model = robots.load(robot)
    worn = layouts.finished(model.name) if layout is None else layouts.Layout.load(layout)
    keys = SkinKeys.of_seed(seed) if key is None else SkinKeys.load(key)
    return SkinUnits(model, worn, keys, controller, host, first_port, seed)


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
        controller: address of a UR controller.
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
