# SPDX-License-Identifier: Apache-2.0
"""`robotskin app balance`."""

from __future__ import annotations

from typing import Annotated

import typer

from robotskin.apps.options import Headless, JsonFile, Port, Seed, SelfCollision, Threads, refuse_in_page, refuse_unless

ROBOT, LAYOUT = "talos_standing", "talos_embrace"
"""A skin whose cells cover the chest's front too, where a person pushes first."""
CELLS_OF_A_SOLE = 7
SOLES_NOTE = (
    f'<div style="margin-top:6px">No sensor at the ankles: {CELLS_OF_A_SOLE} cells of an insole tell the force on each '
    "foot. The insole was calibrated over a force plate, and the robot's weight is known.</div>"
)


def command(
    context: typer.Context,
    headless: Headless = False,
    pushes: Annotated[int, typer.Option(help="How many pushes the script gives.", min=1)] = 3,
    push: Annotated[int | None, typer.Option(help="The cell that the page pushes from the beginning.", min=0)] = None,
    force: Annotated[float, typer.Option(help="Newton of that push.", min=0.5, max=30)] = 15.0,
    soles: Annotated[
        bool, typer.Option("--soles", help="No sensor at the ankles: seven cells in each sole tell the forces.")
    ] = False,
    self_collision: SelfCollision = False,
    seed: Seed = 1,
    json_file: JsonFile = None,
    port: Port = 8080,
    threads: Threads = 1,
) -> None:
    """Push a standing humanoid: it gives way, leans, and stands. Exit status 0: it stood, and no limit was violated."""
    from functools import partial

    from rich.console import Console

    from robotskin.apps.balance import script
    from robotskin.apps.balance.sole_session import SoleSession
    from robotskin.figures import report
    from robotskin.layout import finished
    from robotskin.robots.gains import robot_with_gains
    from robotskin.session import Session

    if headless and push is not None:
        raise typer.BadParameter("is for the page; without it, --pushes tells how many", param_hint="--push")
    refuse_in_page(headless, context, "json_file", "pushes")
    refuse_unless(push is not None, context, "force", because="needs --push")
    console = Console()
    with console.status(f"loading {ROBOT}"):
        ready = robot_with_gains(ROBOT)
        layout = finished(LAYOUT, ROBOT)
        stands = partial(SoleSession, cells=CELLS_OF_A_SOLE) if soles else Session
        session = stands(
            ready.robot, layout, seed=seed, gains=ready.gains, self_collision=self_collision, threads=threads
        )
    if not headless:
        from robotskin.apps.balance.panel import show

        show(session, port, None if push is None else (push, force), SOLES_NOTE if soles else "")
        return
    try:
        with console.status("boot") as status:
            figures = script.run(session, pushes, status.update)
    finally:
        session.shut_down()
    title = f"balance, {ROBOT}, by its soles' cells" if soles else f"balance, {ROBOT}"
    raise typer.Exit(report(console, title, figures, script.bounds(), seed, json_file, [session.fault_told]))
