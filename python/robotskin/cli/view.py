"""`robotskin view ROBOT`: a robot in its skin and its living network, in the browser."""

import threading
from pathlib import Path
from typing import Annotated

import typer


def command(
    robot: Annotated[str, typer.Argument(help="A robot by name, or the path of its URDF.")] = "ur5",
    layout: Annotated[
        Path | None, typer.Option(help="A layout file; by default the finished layout of that robot.", dir_okay=False)
    ] = None,
    network: Annotated[
        bool, typer.Option(help="Run the firmware of all cells, and draw the network as it lives.")
    ] = True,
    seed: Annotated[int, typer.Option(help="Of the network's wires and clocks.")] = 1,
    port: Annotated[int, typer.Option(help="First port to try, on 127.0.0.1.", min=1, max=65535)] = 8080,
) -> None:
    """Show a robot in its skin in the browser: patches, cables and the living network, until interrupted.

    Every cell runs the shipping firmware. Click a wire or a plug to cut it, a cell to kill it, and watch the trees grow
    around the damage, as slowly as you like.
    """
    from contextlib import ExitStack

    from robotskin import robots
    from robotskin.apps.live_network import LiveNetwork
    from robotskin.layout import Layout, finished
    from robotskin.viewer.exhibit import Exhibit

    model = robots.load(robot)
    skin = finished(model.name) if layout is None else Layout.load(layout)
    with ExitStack() as stack:
        living = stack.enter_context(LiveNetwork(skin, seed)) if network and skin.section_unit_ports else None
        exhibit = stack.enter_context(Exhibit(model, skin, port, living))
        typer.echo(f"{model.name} with {len(skin)} cells: open {exhibit.address} (Ctrl-C ends)")
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            typer.echo("closed")
