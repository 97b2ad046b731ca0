# SPDX-License-Identifier: Apache-2.0
"""The options that applications share."""

from pathlib import Path
from typing import Annotated

import typer

from robotskin.outputs import writable_json

__all__ = ["GripperRobot", "Headless", "JsonFile", "KnowledgeFile", "Port", "Seed", "StiffnessRatio"]

Headless = Annotated[bool, typer.Option("--headless", help="No page: run the script, print its figures, and end.")]
Seed = Annotated[int, typer.Option(help="Repeats the run.")]
JsonFile = Annotated[
    Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False, callback=writable_json)
]
Port = Annotated[int, typer.Option(help="First port to try for the page, on 127.0.0.1.", min=1, max=65535)]
GripperRobot = Annotated[str, typer.Option("--robot", help="ur5_gripper or panda_gripper.")]
StiffnessRatio = Annotated[
    float, typer.Option("--ratio", help="Stiffness of hard fruits over that of soft ones.", min=1, max=10)
]
KnowledgeFile = Annotated[
    Path | None, typer.Option("--knowledge", help="Another file of classes, activities and skills.")
]
