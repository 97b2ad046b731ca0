# SPDX-License-Identifier: Apache-2.0
"""`robotskin app grasp`."""

from __future__ import annotations

from typing import Annotated

import typer

from robotskin.apps.options import Headless, JsonFile, Port, Seed, refuse_in_page


def command(
    context: typer.Context,
    name: Annotated[str, typer.Option("--object", help="ball, cylinder or pliers.")] = "ball",
    robot: Annotated[
        str, typer.Option("--robot", help="What carries the hand: allegro_grasp, a carriage; ur5_allegro, an arm.")
    ] = "allegro_grasp",
    primitive: Annotated[bool, typer.Option("--primitive", help="Close by belief alone: the baseline.")] = False,
    equal: Annotated[
        bool, typer.Option("--equal", help="Pliers: each finger presses alike, the other baseline.")
    ] = False,
    error_mm: Annotated[
        float,
        typer.Option(
            help="How far the thing is from where it is believed to be; pliers: at most, along their handles.",
            min=0,
            max=20,
        ),
    ] = 10.0,
    touch: Annotated[float, typer.Option(help="Newton on the back of a finger while it holds.", min=0, max=5)] = 5.0,
    headless: Headless = False,
    seed: Seed = 1,
    json_file: JsonFile = None,
    port: Port = 8080,
) -> None:
    """Grasp a thing that is not where it is believed to be, lift it, hold it, shake it, and touch the hand.

    Exit status 0 means that every figure with a bound keeps it.
    """
    import numpy as np
    from rich.console import Console

    from robotskin.apps.grasp.control import Method
    from robotskin.apps.grasp.fingers import FITS
    from robotskin.apps.grasp.scene import PLIERS, Trial, believed_shape
    from robotskin.apps.grasp.script import Plan, bounds, run, session_of
    from robotskin.errors import InputError, UnknownNameError
    from robotskin.figures import report

    believed_shape(name)
    if name == PLIERS and primitive:
        raise InputError("--primitive with pliers: it knows no handles; use --equal for a baseline")
    if name != PLIERS and equal:
        raise InputError(f"--equal with {name}: it belongs to the pliers; use --primitive for a baseline")
    refuse_in_page(headless, context, "json_file", "touch")
    console = Console()
    method: Method = "primitive" if primitive else "equal" if equal else "reactive"
    generator = np.random.default_rng([seed, 13])
    trial = Trial()
    if error_mm > 0:
        most = 1e-3 * error_mm
        trial = Trial.drawn_along(generator, most) if name == PLIERS else Trial.drawn(generator, (most, most))
    if robot not in FITS:
        raise UnknownNameError("robot that grasps", robot, FITS)
    plan = Plan(name, method, trial, touch_n=touch, robot=robot)
    session = session_of(plan, seed)
    try:
        with console.status("booting the skin") as status:
            session.boot()
            figures = run(session, plan, status.update) if headless else {}
    except BaseException:
        session.shut_down()
        raise
    if not headless:
        from robotskin.apps.grasp.panel import show

        show(session, plan, port)
        return
    session.shut_down()
    title = f"{plan.method} grasp of a {name}, {error_mm:g} mm from its place"
    raise typer.Exit(report(console, title, figures, bounds(plan), seed, json_file, [session.fault_told]))
