# SPDX-License-Identifier: Apache-2.0
"""`robotskin app teach`."""

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
from robotskin.outputs import writable


def command(
    context: typer.Context,
    plan_file: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the plan here.", callback=writable)
    ] = None,
    robot: GripperRobot = "ur5_gripper",
    fruit: Annotated[str, typer.Option(help="A class of fruits of the knowledge file.")] = "orange",
    demonstrations: Annotated[int, typer.Option(help="To learn from, hard and soft in turn.", min=2, max=20)] = 4,
    unseen: Annotated[int, typer.Option(help="Further ones, whose activities are told by the rules.", min=0)] = 0,
    ratio: StiffnessRatio = 2.0,
    lessons_file: Annotated[
        Path | None, typer.Option("--lessons", help="Write here what the rules were learnt from.", callback=writable)
    ] = None,
    knowledge_file: KnowledgeFile = None,
    headless: Headless = False,
    seed: Seed = 1,
    json_file: JsonFile = None,
    port: Port = 8080,
) -> None:
    """Lead a robot by its skin through a task; it learns rules for what is done, and a plan with conditions.

    Exit status 0 means that every figure with a bound keeps it.
    """
    from rich.console import Console

    from robotskin.apps.teach.script import Teaching, bounds, run
    from robotskin.figures import report
    from robotskin.teaching.knowledge import load_knowledge

    refuse_in_page(headless, context, "demonstrations", "unseen", "lessons_file", "json_file")
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
