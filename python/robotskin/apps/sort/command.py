# SPDX-License-Identifier: Apache-2.0
"""`robotskin app sort`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robotskin.apps.options import (
    GripperRobot,
    Headless,
    JsonFile,
    KnowledgeFile,
    Port,
    Seed,
    StiffnessRatio,
    refuse_in_page,
)

IN_PAGE = 20
"""Fruits that the shelf beside the robot takes."""


def command(
    context: typer.Context,
    plan_file: Annotated[
        Path | None, typer.Argument(help="A plan made by robotskin app teach; by default that of oranges.")
    ] = None,
    robot: GripperRobot = "ur5_gripper",
    fruit: Annotated[
        str, typer.Option(help="A class of fruits of the knowledge file: orange, lemon, apple.")
    ] = "orange",
    fruits: Annotated[int, typer.Option(help="How many; at most 20 in the page.", min=1, max=1000)] = 4,
    ratio: StiffnessRatio = 2.0,
    moved_mm: Annotated[float, typer.Option(help="How far places are from those of the file.", min=0, max=100)] = 100.0,
    knowledge_file: KnowledgeFile = None,
    headless: Headless = False,
    seed: Seed = 1,
    json_file: JsonFile = None,
    port: Port = 8080,
) -> None:
    """Squeeze fruits with the skinned pads of a gripper, and put hard ones in a container, soft ones in a bin.

    Exit status 0 means that every figure with a bound keeps it.
    """
    import numpy as np
    from rich.console import Console

    from robotskin.apps.sort.script import Sorting, bounds, drawn_bench, require_fit, run, session_of, usual_plan
    from robotskin.figures import report
    from robotskin.teaching.knowledge import load_knowledge
    from robotskin.teaching.plan import load_plan

    refuse_in_page(headless, context, "json_file")
    if not headless and fruits > IN_PAGE:
        raise typer.BadParameter(
            f"{fruits}: at most {IN_PAGE} in the page; more with --headless", param_hint="--fruits"
        )
    console = Console()
    plan = usual_plan() if plan_file is None else load_plan(plan_file)
    sorting = Sorting(plan, load_knowledge(knowledge_file), robot, fruit, fruits, ratio, moved_m=1e-3 * moved_mm)
    if not headless:
        from robotskin.apps.sort.panel import show

        bench = drawn_bench(sorting, np.random.default_rng([seed, 41, 0]), fruits)
        session = session_of(sorting, bench, 1000 * seed)
        try:
            with console.status("booting the skin"):
                session.boot()
        except BaseException:
            session.shut_down()
            raise
        show(session, sorting, bench, port)
        return
    require_fit(sorting, drawn_bench(sorting, np.random.default_rng([seed, 41, 0]), 1))
    console.print(plan.tree(kind=fruit, scales=sorting.scales), markup=False, highlight=False)
    with console.status("sorts") as status:
        figures, found = run(sorting, seed, status.update)
    for one in found:
        felt = one.done.measured.get("stiffness_n_per_m", float("nan"))
        console.print(
            f"{one.fruit.name}: {1e-3 * one.fruit.stiffness_n_per_m:.2f} N/mm, felt {1e-3 * felt:.2f}, lies in "
            f"{one.ended_in or 'no place'}{'' if one.right else ', which is wrong'}"
            f"{': ' + one.done.why if one.done.why else ''}",
            highlight=False,
        )
    title = f"{robot} sorts {len(found)} fruits ({fruit}), stiffness ratio {ratio:g}"
    raise typer.Exit(report(console, title, figures, bounds(sorting), seed, json_file))
