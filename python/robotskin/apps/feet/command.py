# SPDX-License-Identifier: Apache-2.0
"""`robotskin app feet`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robotskin.apps.feet.settings import FILE
from robotskin.apps.options import Headless, JsonFile, Port, Seed, refuse_in_page


def command(
    context: typer.Context,
    steps: Annotated[
        int, typer.Option(help="How many steps both feet make together; the page begins anew.", min=2)
    ] = 40,
    weight: Annotated[float, typer.Option(help="Newton of wearer and exoskeleton.", min=300, max=1300)] = 850.0,
    settings: Annotated[
        Path,
        typer.Option(
            help="Parameters of touch, nearness and vibration; a copy of the file that is the default.",
            show_default="settings.toml of this application",
        ),
    ] = FILE,
    serial: Annotated[
        Path | None, typer.Option(help="Serial line of three real motors, such as /dev/ttyUSB0, besides the simulated.")
    ] = None,
    test_motors: Annotated[
        bool, typer.Option("--test-motors", help="Run each motor of --serial for half a second; nothing walks.")
    ] = False,
    picture: Annotated[
        Path | None,
        typer.Option(help="Draw two steps of the headless walk, with a scuff if there is one, to this file."),
    ] = None,
    headless: Headless = False,
    seed: Seed = 1,
    json_file: JsonFile = None,
    port: Port = 8080,
) -> None:
    """Let an exoskeleton walk whose soles feel each step, and tell it by three motors on the arm.

    Exit status 0 means that every figure with a bound keeps it. Real motors are driven in the browser only: a headless
    walk does not wait for the clock.
    """
    from rich.console import Console

    from robotskin.apps.feet.gait import Gait
    from robotskin.apps.feet.script import bounds, expected_duty, figures_of, walk
    from robotskin.apps.feet.serial_line import SerialVibrators, try_motors
    from robotskin.apps.feet.settings import read_settings
    from robotskin.apps.feet.walk import FeelingFeet
    from robotskin.figures import report
    from robotskin.outputs import PICTURES, require_writable

    refuse_in_page(headless, context, "json_file", "picture")
    if headless and (serial is not None or test_motors):
        raise typer.BadParameter(
            "a headless walk does not wait for the clock, so real motors cannot follow it; leave --headless out",
            param_hint="--test-motors" if test_motors else "--serial",
        )
    if test_motors and serial is None:
        raise typer.BadParameter("needs --serial, such as /dev/ttyUSB0", param_hint="--test-motors")
    require_writable("--picture", picture, PICTURES)
    console = Console()
    chosen = read_settings(settings)
    line = None if serial is None else SerialVibrators(serial)
    try:
        if test_motors and line is not None:
            try_motors(line, console.print)
            return
        if not headless:
            from robotskin.apps.feet.panel import show

            show(lambda: FeelingFeet(Gait(seed, steps, weight), chosen, seed, line), port)
            return
        feet = FeelingFeet(Gait(seed, steps, weight), chosen, seed)
        with console.status("walks") as status:
            walked = walk(feet, feet.gait.ends_s, expected_duty(feet), status.update)
    finally:
        if line is not None:
            line.close()
    if picture is not None:
        from robotskin.apps.feet.picture import draw

        draw(feet, walked, picture)
    figures = figures_of(feet, walked, feet.gait.steps)
    raise typer.Exit(report(console, f"{steps} steps", figures, bounds(), seed, json_file))
