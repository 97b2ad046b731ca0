# SPDX-License-Identifier: Apache-2.0
"""`robotskin robots`: the robots that are known by name."""

from __future__ import annotations


def command() -> None:
    """List the robots that are known by name, a line each, with what comes ready for them.

    Any other robot is given by the path of its URDF. A robot without a layout is covered by robotskin cover.
    """
    from rich.table import Table

    from robotskin.cli._terminal import terminal
    from robotskin.layout.finished_layouts import finished_names
    from robotskin.robots import robot_names
    from robotskin.robots.catalog import models_folder
    from robotskin.robots.errors import PACKAGE, models_requirement
    from robotskin.robots.gains import robots_with_gains

    names, layouts, gains = robot_names(), set(finished_names()), set(robots_with_gains())
    table = Table(title=f"{len(names)} robots by name")
    for heading in ("robot", "skin", "gains"):
        table.add_column(heading, no_wrap=True)
    for name in sorted(names, key=lambda one: (one not in layouts, one)):
        skin = "finished layout" if name in layouts else "robotskin cover"
        own = "of its own" if name in gains else "made when needed"
        table.add_row(name, skin, own)
    console = terminal()
    console.print(table)
    for line in (
        "one with a finished layout: robotskin demo --robot NAME",
        "any other, or yours: robotskin cover NAME, or robotskin cover FILE.urdf",
    ):
        console.print(line, highlight=False, soft_wrap=True)
    if models_folder() is None:
        console.print(
            f"these and some 70 more need the package {PACKAGE}: pip install {models_requirement()}",
            highlight=False,
            soft_wrap=True,
        )
