# SPDX-License-Identifier: Apache-2.0
"""`robotskin app`: lists the applications; `robotskin app NAME` runs one."""

from __future__ import annotations

from typing import Any

import typer

from robotskin import apps
from robotskin.cli._lazy import LazyGroup
from robotskin.errors import UnknownNameError


class Applications(LazyGroup):
    """One subcommand an application."""

    told_in = "robotskin.apps.{name}"
    runs_in = "robotskin.apps.{name}.command"

    @staticmethod
    def names() -> list[str]:
        """By alphabet."""
        return apps.names()

    def resolve_command(self, context: Any, arguments: list[str]) -> Any:
        """The application that `arguments` begin with. Raises UnknownNameError."""
        if arguments[0] not in self.commands and not arguments[0].startswith("-"):
            raise UnknownNameError("application", arguments[0], list(self.commands))
        return super().resolve_command(context, arguments)


app = typer.Typer(
    cls=Applications,
    invoke_without_command=True,
    add_completion=False,
    help="List the applications, or run one: robotskin app NAME.",
)


@app.callback()
def command(context: typer.Context) -> None:
    """List the applications, or run one: robotskin app NAME."""
    if context.invoked_subcommand is None and isinstance(context.command, Applications):
        width = max((len(name) for name in context.command.commands), default=0)
        for name, one in context.command.commands.items():
            typer.echo(f"{name:{width}}  {one.help}")
