# SPDX-License-Identifier: Apache-2.0
"""List the scenes that come with the project, or check a scene file."""

from __future__ import annotations

from importlib import resources
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from robotskin.world import SceneSpec

TABLE_WIDTH = 110


def command(
    scene: Annotated[
        str | None,
        typer.Argument(
            help="A scene to check and show: name, TOML file, or APP/SCENE of an application. By default: all."
        ),
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
        table.add_section()
        for name, one in app_scenes().items():
            table.add_row(name, f"of robotskin app {name.partition('/')[0]}", one.about)
        console.print(table)
        return
    chosen = app_scenes().get(scene) or load_scene(scene)
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


def app_scenes() -> dict[str, SceneSpec]:
    """The scenes of applications, by APP/SCENE: each TOML file in an application's folder that has things."""
    import tomllib

    from robotskin import apps
    from robotskin.world.scene_files import read_scene

    found: dict[str, SceneSpec] = {}
    for app in apps.names():
        files = sorted(resources.files(apps).joinpath(app).iterdir(), key=lambda file: file.name)
        for file in files:
            text = file.read_text(encoding="utf-8") if file.name.endswith(".toml") else ""
            if "things" in tomllib.loads(text):
                found[f"{app}/{file.name.removesuffix('.toml')}"] = read_scene(text, file.name)
    return found
