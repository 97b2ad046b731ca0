# SPDX-License-Identifier: Apache-2.0
"""`robotskin app teach`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    plan_file: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the plan here.", dir_okay=False)
    ] = None,
    robot: Annotated[str, typer.Option(help="ur5_gripper or panda_gripper.")] = "ur5_gripper",
    fruit: Annotated[str, typer.Option(help="A class of fruits of the knowledge file.")] = "orange",
    demonstrations: Annotated[int, typer.Option(help="To learn from, hard and soft in turn.", min=2, max=20)] = 4,
    unseen: Annotated[int, typer.Option(help="Further ones, whose activities are told by the rules.", min=0)] = 0,
    ratio: Annotated[float, typer.Option(help="Stiffness of hard fruits over that of soft ones.", min=1, max=10)] = 2.0,
    lessons_file: Annotated[
        Path | None, typer.Option("--lessons", help="Write here what the rules were learnt from.", dir_okay=False)
    ] = None,
    knowledge_file: Annotated[
        Path | None, typer.Option("--knowledge", help="Another file of classes, activities and skills.")
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="No page: a scripted teacher leads the robot.")] = False,
    seed: Annotated[int, typer.Option(help="Repeats the run.")] = 1,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False)] = None,
    port: Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)] = 8080,
) -> None:
    """Lead a robot by its skin through a task; it learns rules for what is done, and a plan with conditions.

    Exit status 0 means that every figure with a bound keeps it.
    """
    from rich.console import Console

    from robotskin.apps.teach.script import Teaching, bounds, run
    from robotskin.figures import report
    from robotskin.teaching.knowledge import load_knowledge

    console = Console()
    teaching = Teaching(load_knowledge(knowledge_file), robot, fruit, demonstrations, unseen, ratio)
    if not headless:
        from robotskin.apps.teach.panel import show

        show(teaching, seed, port, plan_file)
        return
    with console.status("teaches") as status:
        figures, taught = run(teaching, seed, status.update)
    console.print("[bold]rules[/]")
    console.print(taught.rules.text("  "), markup=False, highlight=False)
    console.print("[bold]plan[/]")
    console.print(taught.plan.tree(), markup=False, highlight=False)
    remarks = []
    if lessons_file is not None:
        taught.lessons.save(lessons_file)
        remarks.append(f"what the rules were learnt from is in {lessons_file}")
    if plan_file is not None:
        taught.plan.save(plan_file)
        remarks.append(f"the plan is in {plan_file}; carry it out with: robotskin app sort {plan_file}")
    title = f"{robot} is taught by {demonstrations} demonstrations"
    raise typer.Exit(report(console, title, figures, bounds(teaching), seed, json_file, remarks))
