# SPDX-License-Identifier: Apache-2.0
"""List the scenes that come with the project, or check a scene file."""

from typing import Annotated

import typer

TABLE_WIDTH = 110


def command(
    scene: Annotated[
        str | None, typer.Argument(help="Name or TOML file of a scene to check and show; by default all are listed.")
    ] = None,
) -> None:
    """List the scenes that come with the project, or check a scene file and show what is in it."""
    from rich.table import Table

    from robotskin.cli._terminal import terminal
    from robotskin.world.scene_files import load_scene, scene_names

    console = terminal()
    if console.width < TABLE_WIDTH:
        console = terminal(TABLE_WIDTH)
    if scene is None:
        table = Table("scene", "robots", "what is there")
        for name in scene_names():
            one = load_scene(name)
            table.add_row(name, ", ".join(one.robots) or "any", one.about)
        console.print(table)
        return
    chosen = load_scene(scene)
    table = Table("thing", "moves", "parts", "mass kg", "friction", "stiffness N/m", "reflectance", title=chosen.about)
    for thing in chosen.things:
        parts = thing.all_parts()
        table.add_row(
            thing.name,
            thing.moves,
            ", ".join(part.shape.__class__.__name__.lower() for part in parts),
            "–" if thing.moves in ("fixed", "path") else f"{sum(part.mass_kg for part in parts):g}",
            f"{thing.friction:g}",
            "rigid" if thing.stiffness_n_per_m is None else f"{thing.stiffness_n_per_m:g} ({thing.gives})",
            "drawn" if thing.reflectance is None else f"{thing.reflectance:g}",
        )
    console.print(table)
