# SPDX-License-Identifier: Apache-2.0
"""`robotskin app propagate`."""

from __future__ import annotations

from typing import Annotated

import typer

from robotskin.apps.options import Headless, JsonFile, Port, Seed, refuse_in_page, refuse_unless


def command(
    context: typer.Context,
    robot: Annotated[
        str, typer.Option(help="By name; one of its limbs carries others: dual_arm, dual_arm_gripper, talos.")
    ] = "dual_arm",
    push: Annotated[
        int | None,
        typer.Option(
            help="The cell to push; headless by default one of the right shoulder or of a limb's first link, in the "
            "page by default none."
        ),
    ] = None,
    force: Annotated[float, typer.Option(help="Newton at the end of the rise, of 2 N/s.", min=0.5, max=20)] = 8.0,
    wait: Annotated[float, typer.Option(help="Seconds to wait after the release.", min=0, max=600)] = 10.0,
    without: Annotated[bool, typer.Option("--without", help="Arms that hand nothing on: the base stays.")] = False,
    headless: Headless = False,
    seed: Seed = 1,
    json_file: JsonFile = None,
    port: Port = 8080,
) -> None:
    """Push a mobile robot with two arms: where an arm cannot give way, its base does, and comes back when let go.

    Exit status 0 means that every figure with a bound keeps it.
    """
    from rich.console import Console

    from robotskin.apps.propagate.script import Plan, bounds, run, usual_cell
    from robotskin.apps.propagate.tasks import WITH, carrying_limb, use_arms_alone
    from robotskin.figures import report
    from robotskin.layout import finished
    from robotskin.robots import load
    from robotskin.session import Session

    refuse_in_page(headless, context, "json_file", "wait")
    refuse_unless(headless or push is not None, context, "force", because="is for --push")
    console = Console()
    loaded = load(robot)
    carrying = carrying_limb(loaded).name
    skin = finished(robot)
    session = Session(loaded, skin, WITH, seed=seed, interface="velocity", link="in process")
    try:
        plan = Plan(usual_cell(session) if push is None else push, force, wait_s=wait)
        session.in_world(plan.cell)
        if without:
            use_arms_alone(session)
        with console.status("booting the skin") as status:
            session.boot()
            figures = run(session, plan, status.update) if headless else {}
    except BaseException:
        session.shut_down()
        raise
    if not headless:
        from robotskin.apps.propagate.panel import show

        show(session, port, None if push is None else plan)
        return
    session.shut_down()
    link = skin.links[skin.link[plan.cell]]
    title = f"cell {plan.cell} of {link}, {force:g} N, {'limbs alone' if without else f'limbs and {carrying}'}"
    raise typer.Exit(report(console, title, figures, bounds(plan), seed, json_file, [session.fault_told]))
