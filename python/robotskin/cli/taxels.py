# SPDX-License-Identifier: Apache-2.0
"""`robotskin taxels`: a layout of another maker's taxels."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def command(
    files: Annotated[list[Path], typer.Argument(help="iCub taxel files; a group of cells each.", exists=True)],
    robot: Annotated[str, typer.Option(help="The robot that wears them, by name or URDF.")],
    out: Annotated[Path, typer.Option(help="Write the layout here (JSON).", dir_okay=False)],
    link: Annotated[str | None, typer.Option(help="Put all on this link instead of those that the files name.")] = None,
    at: Annotated[
        str | None,
        typer.Option(help="How the files' frame lies in the link's: 'X Y Z ROLL PITCH YAW', metres and radians."),
    ] = None,
) -> None:
    """Make a layout of the taxels of another maker's skin.

    Reads the taxel files of the iCub. robotskin connect --skin then runs on it.
    """
    import numpy as np

    from robotskin import robots
    from robotskin.cli._terminal import terminal
    from robotskin.cli._waiting import waiting
    from robotskin.errors import InputError
    from robotskin.layout.taxel_layout import taxel_layout
    from robotskin.outputs import require_writable

    require_writable("--out", out, (".json", ".json.gz"))
    link_from_skin = None
    if at is not None:
        from scipy.spatial.transform import Rotation

        try:
            numbers = np.array([float(word) for word in at.split()])
        except ValueError:
            numbers = np.empty(0)
        if len(numbers) != 6 or not np.isfinite(numbers).all():
            raise InputError(f"--at {at!r}: six numbers, 'X Y Z ROLL PITCH YAW'")
        link_from_skin = np.eye(4)
        link_from_skin[:3, :3] = Rotation.from_euler("xyz", numbers[3:]).as_matrix()
        link_from_skin[:3, 3] = numbers[:3]
    with waiting(f"loading {robot}"):
        layout, found = taxel_layout(files, robots.load(robot), link, link_from_skin)
    layout.save(out)
    console = terminal()
    for one in found:
        normals = "normals made of the places" if one.made_normals else "normals of the file"
        console.print(
            f"{Path(one.file).name}: group {one.group}, {one.cells} taxels on {one.link}, {normals}, "
            f"{one.off_mesh_m * 1e3:.0f} mm off the robot's surface (median)",
            highlight=False,
            soft_wrap=True,
        )
    console.print(f"{len(layout)} taxels written to {out}", highlight=False, soft_wrap=True)
