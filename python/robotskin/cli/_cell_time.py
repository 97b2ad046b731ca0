# SPDX-License-Identifier: Apache-2.0
"""The option `--cells-take-time` of verbs that run a network."""

from typing import Annotated

import typer


def _enter(context: typer.Context, on: bool) -> bool:
    if on:
        from robotskin.world.ideal import cells_take_time

        context.with_resource(cells_take_time())
    return on


CellTime = Annotated[
    bool,
    typer.Option(
        "--cells-take-time",
        callback=_enter,
        help="Each cell's processor takes its time: 48 MHz, one flash wait state (docs/network.md).",
    ),
]
