# SPDX-License-Identifier: Apache-2.0
"""`robotskin layouts`: the finished layouts."""

from __future__ import annotations


def command() -> None:
    """List the finished layouts that come with the project, a line each."""
    from rich.table import Table

    from robotskin.cli._terminal import terminal
    from robotskin.layout import finished
    from robotskin.layout.finished_layouts import finished_names

    table = Table(title="finished layouts")
    for heading in ("name", "robot", "cells", "patches", "section units", "links"):
        named = heading in ("name", "robot")  # is typed again, so it stands there whole
        table.add_column(heading, justify="left" if named else "right", no_wrap=named)
    for name in finished_names():
        skin = finished(name)
        units = len(set(skin.group.tolist()))
        table.add_row(name, skin.robot, str(len(skin)), str(len(skin.patches)), str(units), str(len(skin.links)))
    console = terminal()
    console.print(table)
    console.print("A robot of yours: robotskin cover FILE.urdf")
