# SPDX-License-Identifier: Apache-2.0
"""`robotskin app grasp`."""

from __future__ import annotations

from typing import Annotated

import typer

from robotskin.apps.options import Headless, JsonFile, Port, Seed


def command(
    name: Annotated[str, typer.Option("--object", help="ball or cylinder.")] = "ball",
    primitive: Annotated[bool, typer.Option("--primitive", help="Close by belief alone: the baseline.")] = False,
    error_mm: Annotated[
        float, typer.Option(help="How far the thing is from where it is believed to be.", min=0, max=20)
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

    from robotskin.apps.grasp.scene import Trial
    from robotskin.apps.grasp.script import Plan, bounds, run, session_of
    from robotskin.figures import report

    console = Console()
    generator = np.random.default_rng([seed, 13])
    trial = Trial.drawn(generator, (1e-3 * error_mm, 1e-3 * error_mm)) if error_mm > 0 else Trial()
    plan = Plan(name, "primitive" if primitive else "reactive", trial, touch_n=touch)
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
