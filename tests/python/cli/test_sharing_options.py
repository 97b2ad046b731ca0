# SPDX-License-Identifier: Apache-2.0
"""Options whose number may be left out."""

from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from robotskin.cli._lazy import VerbCommand
from robotskin.cli._sharing import Foxglove
from robotskin.sharing import FOXGLOVE_PORT


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "None ur5"),
        (["--foxglove"], f"{FOXGLOVE_PORT} ur5"),
        (["--foxglove", "0"], "0 ur5"),
        (["--foxglove", "9000", "panda"], "9000 panda"),
        (["--foxglove", "panda"], f"{FOXGLOVE_PORT} panda"),
        (["panda", "--foxglove"], f"{FOXGLOVE_PORT} panda"),
    ],
)
def test_a_number_may_be_left_out(arguments: list[str], told: str) -> None:
    app = typer.Typer()

    @app.command(cls=VerbCommand)
    def verb(robot: Annotated[str, typer.Argument()] = "ur5", foxglove: Foxglove = None) -> None:
        typer.echo(f"{foxglove} {robot}")

    done = CliRunner().invoke(app, arguments)
    assert done.stdout.strip() == told, done.output


def test_a_path_of_the_same_name_stays_one() -> None:
    app = typer.Typer()

    @app.command(cls=VerbCommand)
    def verb(foxglove: Annotated[str | None, typer.Option("--foxglove")] = None) -> None:
        typer.echo(foxglove)

    assert CliRunner().invoke(app, ["--foxglove", "touches.mcap"]).stdout.strip() == "touches.mcap"


def test_a_port_that_cannot_be_is_refused() -> None:
    app = typer.Typer()

    @app.command(cls=VerbCommand)
    def verb(foxglove: Foxglove = None) -> None: ...

    assert CliRunner().invoke(app, ["--foxglove", "99999"]).exit_code == 2
