"""The `robotskin` command: one subcommand a verb, each in its own module."""

import typer

from robotskin.cli import bench

app = typer.Typer(no_args_is_help=True, add_completion=False, help="A sense of touch for the whole body of any robot.")
app.add_typer(bench.app, name="bench")


@app.callback()
def main() -> None:
    """A sense of touch for the whole body of any robot."""
