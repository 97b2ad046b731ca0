# SPDX-License-Identifier: Apache-2.0
"""The option `--threads` of verbs that run a whole robot."""

from typing import Annotated

import typer

Threads = Annotated[
    int,
    typer.Option(
        "--threads",
        min=1,
        max=64,
        help="That simulate groups of section units side by side; the run is the same for any number.",
    ),
]
