# SPDX-License-Identifier: Apache-2.0
"""`robotskin port check NAME`: whether a robot port keeps the laws of docs/robot_port.md."""

from __future__ import annotations

from typing import Annotated

import typer

app = typer.Typer(add_completion=False, no_args_is_help=True, help="Check the port of a robot, also one of your own.")


@app.callback()
def command() -> None:
    """Check the port of a robot, also one of your own."""


@app.command("check")
def check(
    port: Annotated[
        str, typer.Argument(help="ur:ADDRESS, franka:ADDRESS, ros2:DOMAIN[,KEY=VALUE]…, or MODULE:CLASS of your own.")
    ],
    robot: Annotated[str | None, typer.Option(help="The robot that it moves, by name or URDF.")] = None,
    move: Annotated[
        bool, typer.Option("--move", help="The robot may move: its last joint turns by some 0.1 rad.")
    ] = False,
) -> None:
    """Look at every law of a robot port (docs/robot_port.md) and tell what was seen.

    Without --move nothing moves, and the laws that need motion are not tested. Exit status 0: no law is broken.
    """
    from robotskin.ports import Verdict, made_port
    from robotskin.ports import check as look
    from robotskin.robots.gains import robot_with_gains

    moved = None if robot is None else robot_with_gains(robot).robot
    checked = made_port(port, moved)
    findings = look(checked, robot=moved, moves=move)
    if hasattr(checked, "close"):
        checked.close()
    for finding in findings:
        typer.echo(str(finding))
    broken = sum(finding.verdict is Verdict.broken for finding in findings)
    typer.echo(f"{broken} of {len(findings)} laws broken" if broken else "no law broken")
    raise typer.Exit(1 if broken else 0)
