# SPDX-License-Identifier: Apache-2.0
"""`robotskin gains`: make the gain file of a robot, or list the robots that have one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robotskin.cli._waiting import waiting


def command(
    robot: Annotated[
        str | None, typer.Argument(help="A robot by name, or the path of its URDF; without it, what gains there are.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The gain file; ROBOT.toml by default.", dir_okay=False)
    ] = None,
    home: Annotated[
        str | None,
        typer.Option(help="Where the robot stands: rad for every joint that is not locked, with commas between."),
    ] = None,
    lock: Annotated[
        str | None,
        typer.Option(
            help="Joints to hold for good, NAME or NAME=RAD with commas between, or none; by default wheels and the "
            "coupled joints of grippers."
        ),
    ] = None,
) -> None:
    """Make the gain file of a robot from its inertia and limits, or list the robots that have gains.

    The robot gets a home posture, a stiffness for every joint, and limits; contacts are tested to settle. Then
    `robotskin run ROBOT --gains FILE` runs it. Examples:

    robotskin gains panda

    robotskin gains my_arm.urdf -o my_arm.toml --lock gripper_joint=0.02
    """
    import numpy as np
    from rich.table import Table

    from robotskin import robots
    from robotskin.cli._terminal import terminal
    from robotskin.cli.run import numbers_of
    from robotskin.errors import InputError
    from robotskin.outputs import require_writable
    from robotskin.robots.gains.gain_file import written
    from robotskin.robots.gains.made import heading, made_gains
    from robotskin.robots.locking import joints_to_lock
    from robotskin.whole_file import whole_file

    console = terminal()
    if robot is None:
        for option, value in (("--output", output), ("--home", home), ("--lock", lock)):
            if value is not None:
                raise InputError(f"{option} {value}: name the robot first, robotskin gains ROBOT")
        list_gains(console)
        return
    require_writable("--output", output, (".toml",))
    model = robots.load(robot)
    locked = joints_to_lock(model) if lock is None else locks_of(lock, model)
    if locked:
        model = robots.load(robot, locked=locked)
    posture = numbers_of(home, "--home")
    if posture is not None and len(posture) != model.joint_count:
        raise InputError(
            f"--home of {len(posture)} numbers: {model.name} has {model.joint_count} joints, "
            f"{', '.join(model.joint_names)}"
        )
    with waiting(f"gains of {model.name}"):
        made = made_gains(model, None if posture is None else np.array(posture))
    target = output or Path(f"{model.name}.toml")
    with whole_file(target) as partial:
        partial.write_text(written(made.gains.values, heading(made, model)), encoding="utf-8")
    values = made.gains.values
    table = Table(title=f"{model.name}: {model.joint_count} joints")
    for name in ("joint", "home", "stiffness", "inertia", "added", "farthest point m"):
        table.add_column(name, justify="left" if name == "joint" else "right", overflow="fold")
    for row, joint in enumerate(model.joint_names):
        table.add_row(
            joint,
            f"{values['posture']['home'][row]:.3f}",
            f"{values['joint']['stiffness'][row]:g}",
            f"{made.inertia[row]:.3g}",
            f"{values['virtual_robot']['inertia'][row]:g}",
            f"{made.lever_m[row]:.3f}",
        )
    console.print(table)
    told = ", ".join(f"{joint} at {position:g}" for joint, position in locked.items())
    lines = [
        "Home in rad or m, stiffness in Nm/rad or N/m, inertia in kg m² or kg.",
        *([f"Locked: {told}."] if told else []),
        f"The hand is {values['cartesian']['link']}.",
        *heading(made, model)[2:],
        f"gains written to {target}; next: robotskin run {robot} --gains {target}",
    ]
    for line in lines:
        console.print(line, highlight=False, soft_wrap=True)


def locks_of(text: str, model: object) -> dict[str, float]:
    """Joints and positions of --lock; a joint without one is held where it is nearest to neutral inside its limits.

    Raises InputError for a position that is no number, UnknownNameError for a joint that there is not.
    """
    from robotskin.errors import InputError
    from robotskin.robots import Robot
    from robotskin.robots.locking import inside_limits

    assert isinstance(model, Robot)
    found: dict[str, float] = {}
    for part in text.split(",") if text.strip() != "none" else ():
        name, equals, position = part.strip().partition("=")
        row = model.joint_index(name)
        try:
            found[name] = float(position) if equals else float(inside_limits(model)[row])
        except ValueError:
            raise InputError(f"--lock {part}: {position!r} is no number; write {name}=0.02") from None
    return found


def list_gains(console: object) -> None:
    """A line for each robot whose gains come with the project."""
    from rich.console import Console
    from rich.table import Table

    from robotskin.robots.gains import GainSet, robots_with_gains

    assert isinstance(console, Console)
    table = Table(title="robots with gains of their own")
    for name in ("robot", "joints", "locked", "hand"):
        table.add_column(name, justify="right" if name in ("joints", "locked") else "left", no_wrap=name == "robot")
    for robot in robots_with_gains():
        gains = GainSet.load(robot)
        table.add_row(robot, str(len(gains.home)), str(len(gains.locked)), str(gains.values["cartesian"]["link"]))
    console.print(table)
    console.print("For all others gains are made when they are needed; robotskin gains ROBOT -o FILE writes them.")
