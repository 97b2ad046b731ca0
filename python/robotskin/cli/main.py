# SPDX-License-Identifier: Apache-2.0
"""The `robotskin` command: one subcommand a verb, each in the module of this folder that bears its name.

A verb's module offers either `command`, a function that typer turns into the subcommand, or `app`, a `typer.Typer` of
further subcommands. It is imported when its verb is called, so that `robotskin --help` answers at once however heavy
the verbs are; their one-line summaries are read from their sources.
"""

from __future__ import annotations

import pkgutil
import signal
from typing import Annotated, Any

import typer
from typer.exceptions import TyperException

import robotskin
import robotskin.cli
from robotskin.cli._entry import status_after
from robotskin.cli._interruption import Interruption
from robotskin.cli._lazy import LazyGroup
from robotskin.cli._mistakes import one_line
from robotskin.errors import RobotskinError

# The order of a project's day; verbs that are not named here follow by alphabet.
ORDER = (
    "demo",
    "robots",
    "layouts",
    "cover",
    "taxels",
    "check",
    "gains",
    "simulate",
    "configure",
    "calibrate",
    "run",
    "app",
    "scenes",
    "view",
    "keys",
    "port",
    "chip",
    "commission",
    "unit",
    "cell",
    "rehearse",
    "connect",
    "record",
    "replay",
    "export",
    "fleet",
    "doctor",
    "bench",
    "reproduce",
)


def verbs() -> list[str]:
    """The names of all verbs, in the order in which the help lists them."""
    found = [
        module.name
        for module in pkgutil.iter_modules(robotskin.cli.__path__)
        if module.name != "main" and module.name[0] != "_"
    ]
    return sorted(found, key=lambda verb: (ORDER.index(verb) if verb in ORDER else len(ORDER), verb))


class Verbs(LazyGroup):
    """Loads the verb that is called, and turns the project's own errors into one line on stderr and exit status 2.

    Any other exception is a bug and is shown as one.
    """

    told_in = runs_in = "robotskin.cli.{name}"
    names = staticmethod(verbs)

    def invoke(self, context: Any) -> Any:
        """Run the verb that `context` holds."""
        try:
            with Interruption() as interruption:
                return super().invoke(context)
        except RobotskinError as error:
            reason = str(error)
        except TyperException as error:
            told = one_line(error)
            if told is None:
                raise
            typer.echo(told, err=True)
            raise typer.Exit(2) from None
        except OSError as error:
            # Only a file can be named by the user.
            if error.filename is None:
                raise
            reason = f"{error.filename}: {error.strerror}"
        except KeyboardInterrupt:
            reason = ""
        except Exception as error:
            # What tidies up after a signal may fail in its own way.
            if interruption.came is None or isinstance(error, typer.Exit):
                raise
            reason = ""
        if not reason:
            typer.echo("robotskin: interrupted", err=True)
            raise typer.Exit(status_after(interruption.came or signal.SIGINT))
        typer.echo(f"robotskin: {' '.join(reason.split())}", err=True)
        raise typer.Exit(2)


def show_version(wanted: bool) -> None:
    """Print the version and leave, where it is `wanted`."""
    if wanted:
        typer.echo(robotskin.__version__)
        raise typer.Exit


app = typer.Typer(
    cls=Verbs,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_show_locals=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """A sense of touch for the whole body of any robot."""
