"""`robotskin view ROBOT`: a robot in its skin, in the browser."""

import threading
from pathlib import Path
from typing import Annotated

import typer


def command(
    robot: Annotated[str, typer.Argument(help="A robot by name, or the path of its URDF.")] = "ur5",
    layout: Annotated[
        Path | None, typer.Option(help="A layout file; by default the finished layout of that robot.", dir_okay=False)
    ] = None,
    port: Annotated[int, typer.Option(help="First port to try, on 127.0.0.1.", min=1, max=65535)] = 8080,
) -> None:
    """Show a robot in its skin in the browser: patches, network, cables; until interrupted."""
    from robotskin import robots
    from robotskin.layout import Layout, finished
    from robotskin.viewer.exhibit import Exhibit

    model = robots.load(robot)
    skin = finished(model.name) if layout is None else Layout.load(layout)
    with Exhibit(model, skin, port) as exhibit:
        typer.echo(f"{model.name} with {len(skin)} cells: open {exhibit.address} (Ctrl-C ends)")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            typer.echo("closed")
