# SPDX-License-Identifier: Apache-2.0
"""`robotskin rehearse`: a robot's controller and section units that are not there, for a first `robotskin connect`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    import queue


def command(
    robot: Annotated[
        str, typer.Argument(help="A UR by name, or its URDF; panda with --franka; any robot with --ros2.")
    ] = "ur5",
    key: Annotated[
        Path | None, typer.Option(help="The skin's keys (robotskin keys FILE).", exists=True, dir_okay=False)
    ] = None,
    layout: Annotated[
        Path | None,
        typer.Option(help="A layout file; by default the robot's finished layout.", exists=True, dir_okay=False),
    ] = None,
    host: Annotated[str, typer.Option(help="Address of this machine for both.")] = "127.0.0.1",
    units_port: Annotated[int, typer.Option(help="Of the first section unit.", min=1, max=65535)] = 21100,
    version: Annotated[str, typer.Option(help="Of the controller's software.")] = "5.23.0",
    serial: Annotated[
        Path | None,
        typer.Option(help="Serve the cells on pseudo-terminals in this folder, for robotskin unit.", file_okay=False),
    ] = None,
    ros2: Annotated[
        int | None,
        typer.Option(help="Instead of a UR controller: forward controllers of ros2_control in this domain.", min=0),
    ] = None,
    franka: Annotated[
        bool, typer.Option("--franka", help="Instead of a UR controller: a Franka (franky-sim).")
    ] = False,
    touch: Annotated[bool, typer.Option("--touch", help="A hand pushes cells, drawn from the seed.")] = False,
    seconds: Annotated[float, typer.Option(help="For how long; 0: until Ctrl-C.", min=0)] = 0.0,
    seed: Annotated[int, typer.Option(help="Of the skin and the touches.")] = 1,
) -> None:
    """Serve a robot's controller and the section units of its skin on this machine, each in a process of its own.

    Then robotskin connect runs against them as against real ones. The number of a cell, typed here, touches it.
    """
    import queue
    import random
    import time
    from contextlib import ExitStack

    from robotskin.errors import InputError
    from robotskin.rehearsal import Asked, ControllerSettings, Look, controller, franka_controller, serial_skin, skin

    if franka and ros2 is not None:
        raise InputError("--franka, --ros2: one controller at a time")
    parts = version.split(".")
    if not 2 <= len(parts) <= 4 or not all(part.isdigit() for part in parts):
        raise InputError(f"--version {version}: give it as 5.23.0")
    numbers = ([int(part) for part in parts] + [0, 0])[:4]
    settings = ControllerSettings(version=(numbers[0], numbers[1], numbers[2], numbers[3]))
    keyed = f"--key {key}" if key else "--key FILE (make one with robotskin keys, and give it here, too)"
    worn = f" --layout {layout}" if layout else ""
    with ExitStack() as held:
        if ros2 is not None:
            from robotskin.rehearsal.ros2_process import forward_controllers

            port = followed = f"ros2:{ros2}"
            held.enter_context(forward_controllers(robot, ros2))
        elif franka:
            port = followed = f"franka:{host}"
            held.enter_context(franka_controller(robot, host))
        else:
            port, followed = f"ur:{host}", host
            held.enter_context(controller(robot, host, settings))
        if serial is None:
            made = skin(robot, followed, layout=layout, key=key, host=host, first_port=units_port, seed=seed)
        else:
            made = serial_skin(robot, serial, followed, layout=layout, key=key, seed=seed)
        units = held.enter_context(made)
        cells = units.ask(Look(("world.scene.cell_body.size",)))[0]
        if serial is None:
            addresses = units.ask(Look(("addresses",)))[0]
        else:
            ports: dict[tuple[int, int], list[str]] = {}
            for (group, unit, _), path in units.ask(Look(("lines",)))[0].items():
                ports.setdefault((group, unit), []).append(path)
            addresses = []
            for (group, unit), paths in ports.items():
                addresses.append((host, units_port + len(addresses)))
                at = f"--listen {host}:{addresses[-1][1]} --group {group} --unit {unit} {keyed}"
                typer.echo(f"robotskin unit {' '.join(paths)} {at}")
        told = " ".join(f"--units {address}:{port}" for address, port in addresses)
        typer.echo(f"robotskin connect {robot} --robot-port {port} {told} {keyed}{worn}")
        began, draw, typed = time.monotonic(), random.Random(seed), typed_lines()
        while seconds == 0 or time.monotonic() - began < seconds:
            cell = draw.randrange(cells) if touch else None
            if not touch:
                try:
                    line = typed.get(timeout=PAUSE_S)
                except queue.Empty:
                    continue
                if not line.isdigit() or int(line) >= cells:
                    typer.echo(f"{line!r} is no cell: type a number below {cells}")
                    continue
                cell = int(line)
            units.ask(Asked("push", (cell, draw.uniform(5.0, 15.0))))
            time.sleep(PAUSE_S)
            units.ask(Asked("release"))
            time.sleep(PAUSE_S if touch else 0.0)


PAUSE_S = 1.0


def typed_lines() -> queue.SimpleQueue[str]:
    """What is typed in this terminal or comes by a pipe, line by line; nothing where this runs in the background."""
    import os
    import queue
    import sys
    import threading

    typed: queue.SimpleQueue[str] = queue.SimpleQueue()
    if sys.stdin.isatty() and os.tcgetpgrp(sys.stdin.fileno()) != os.getpgrp():
        return typed  # to read would stop it

    def read() -> None:
        for line in sys.stdin:
            if line.strip():
                typed.put(line.strip())

    threading.Thread(target=read, daemon=True).start()
    return typed
