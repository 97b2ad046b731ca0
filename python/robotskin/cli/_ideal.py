# SPDX-License-Identifier: Apache-2.0
"""The option `--ideal` of every verb that runs a world."""

from typing import Annotated

import typer


def _enter(context: typer.Context, ideal: bool) -> bool:
    if ideal:
        from robotskin.world.ideal import ideal_world

        context.with_resource(ideal_world())
    return ideal


Ideal = Annotated[
    bool,
    typer.Option(
        "--ideal",
        callback=_enter,
        help="A world that is just as its models say, but for noise, offset, scale and drift (docs/imperfections.md).",
    ),
]
