# SPDX-License-Identifier: Apache-2.0
"""The option `--ideal-processors` of verbs that run a network."""

from typing import Annotated

import typer


def _enter(context: typer.Context, on: bool) -> bool:
    if on:
        from robotskin.world.ideal import cells_take_time

        context.with_resource(cells_take_time(False))
    return on


IdealProcessors = Annotated[
    bool,
    typer.Option(
        "--ideal-processors",
        callback=_enter,
        help="Cells compute in no time. Without it each has a processor of 48 MHz, one flash wait state.",
    ),
]
