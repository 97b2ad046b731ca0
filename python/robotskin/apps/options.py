# SPDX-License-Identifier: Apache-2.0
"""The options that applications share."""

from pathlib import Path
from typing import Annotated

import typer

from robotskin.outputs import writable

__all__ = [
    "GripperRobot",
    "Headless",
    "JsonFile",
    "KnowledgeFile",
    "Port",
    "Seed",
    "SelfCollision",
    "StiffnessRatio",
    "Threads",
    "refuse_in_page",
    "refuse_unless",
]

Headless = Annotated[bool, typer.Option("--headless", help="No page: run the script, print its figures, and end.")]
Seed = Annotated[int, typer.Option(help="Repeats the run.", min=0)]
JsonFile = Annotated[
    Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False, callback=writable)
]
SelfCollision = Annotated[
    bool, typer.Option("--self-collision", help="Keep bodies apart and joints off their ends, before all else.")
]
Port = Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)]
GripperRobot = Annotated[str, typer.Option("--robot", help="ur5_gripper or panda_gripper.")]
StiffnessRatio = Annotated[
    float, typer.Option("--ratio", help="Stiffness of hard fruits over that of soft ones.", min=1, max=10)
]
Threads = Annotated[
    int,
    typer.Option(
        "--threads",
        min=1,
        max=64,
        help="That simulate groups of section units side by side; the run is the same for any number.",
    ),
]
KnowledgeFile = Annotated[
    Path | None, typer.Option("--knowledge", help="Another file of classes, activities and skills.")
]


def refuse_in_page(headless: bool, context: typer.Context, *names: str) -> None:
    """Refuse options, by the names of their arguments, that were given and that a page has no use for.

    Raises:
        typer.BadParameter: names them.
    """
    refuse_unless(headless, context, *names, because="is for --headless")


def refuse_unless(of_use: bool, context: typer.Context, *names: str, because: str) -> None:
    """Refuse options, by the names of their arguments, that were given where they are of no use.

    Raises:
        typer.BadParameter: names them, and says `because`.
    """
    sources = {name: context.get_parameter_source(name) for name in names}
    given = [name for name, source in sources.items() if source is not None and source.name == "COMMANDLINE"]
    if given and not of_use:
        options = [parameter.opts[0] for parameter in context.command.params if parameter.name in given]
        raise typer.BadParameter(because, param_hint=", ".join(options))
