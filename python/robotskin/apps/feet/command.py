# SPDX-License-Identifier: Apache-2.0
"""`robotskin app feet`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robotskin.apps.feet.settings import FILE


def command(
    steps: Annotated[
        int, typer.Option(help="How many steps both feet make together; the page begins anew.", min=2)
    ] = 40,
    weight: Annotated[float, typer.Option(help="Newton of wearer and exoskeleton.", min=300, max=1300)] = 850.0,
    settings: Annotated[
        Path, typer.Option(help="Parameters of touch, nearness and vibration; a copy of the file that is the default.")
    ] = FILE,
    serial: Annotated[
        Path | None, typer.Option(help="Serial line of three real motors, such as /dev/ttyUSB0, besides the simulated.")
    ] = None,
    headless: Annotated[
        bool, typer.Option("--headless", help="No page: walk, compare with the truth, and end.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Repeats the run.")] = 1,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False)] = None,
    port: Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)] = 8080,
) -> None:
    """Let an exoskeleton walk whose soles feel each step, and tell it by three motors on the arm.

    Exit status 0 means that every figure with a bound keeps it.
    """
    from rich.console import Console

    from robotskin.apps.feet.gait import Gait
    from robotskin.apps.feet.script import bounds, figures_of, walk
    from robotskin.apps.feet.settings import read_settings
    from robotskin.apps.feet.vibration import SerialVibrators
    from robotskin.apps.feet.walk import FeelingFeet
    from robotskin.figures import report

    console = Console()
    chosen = read_settings(settings)
    line = None if serial is None else SerialVibrators(serial)
    try:
        if not headless:
            from robotskin.apps.feet.panel import show

            show(lambda: FeelingFeet(Gait(seed, steps, weight), chosen, seed, line), port)
            return
        feet = FeelingFeet(Gait(seed, steps, weight), chosen, seed, line)
        with console.status("walks") as status:
            walked = walk(feet, feet.gait.ends_s, status.update)
    finally:
        if line is not None:
            line.close()
    figures = figures_of(feet, walked, feet.gait.steps)
    raise typer.Exit(report(console, f"{steps} steps", figures, bounds(), seed, json_file))
