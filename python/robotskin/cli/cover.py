"""Cover a robot with skin cells and write the layout."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

TABLE_WIDTH = 110
"""Columns below which the tables would be cut to pieces."""


def command(
    robot: Annotated[str, typer.Argument(help="Name of a robot, or path of a URDF.")],
    links: Annotated[
        str | None, typer.Option(help="Links to cover, with commas between; by default those of the robot's plan.")
    ] = None,
    cells: Annotated[int | None, typer.Option(min=1, help="Cells in all; by default as the robot's plan says.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Layout file, .json or .json.gz; ROBOT.json by default.")
    ] = None,
    picture: Annotated[Path | None, typer.Option(help="Draw the covered robot into this PNG file.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same layout.")] = 0,
    foam_mm: Annotated[float | None, typer.Option(min=0.5, max=30, help="Foam between robot and cells.")] = None,
    overhang: Annotated[
        float | None, typer.Option(min=0, max=1, help="Share of a cell's back that may stand off the robot.")
    ] = None,
    tries: Annotated[
        int | None, typer.Option(min=1, help="First cells tried for each patch; more is slower, better.")
    ] = None,
) -> None:
    """Cover a robot with skin cells and write the layout.

    Patches of the hexagonal lattice grow over the links' meshes by the hinge rule t = a_p - R a_q, clear of the
    neighbouring links over the joint range, then are trimmed to exactly the number of cells asked for, wired to
    section units (66 cells a port at most) and measured.
    """
    from dataclasses import replace

    from robotskin import robots
    from robotskin.apps.outputs import require_writable
    from robotskin.layout.covering import cover
    from robotskin.layout.errors import CoveringError
    from robotskin.layout.places import Rules
    from robotskin.layout.plans import PLANS
    from robotskin.layout.report import report

    console = Console()
    if console.width < TABLE_WIDTH:
        console = Console(width=TABLE_WIDTH)
    require_writable("--output", output, (".json", ".json.gz", ".gz"))
    require_writable("--picture", picture, (".png",))
    body = robots.load(robot)
    plan = PLANS.get(body.name)
    chosen = tuple(links.split(",")) if links else plan.links if plan else None
    count = cells or (plan.cells if plan else None)
    if chosen is None or count is None:
        surfaces = ", ".join(body.links_with("collision"))
        raise CoveringError(
            f"no plan for {body.name}: give --cells and --links; links with a surface are {surfaces}; "
            f"there are plans for {', '.join(PLANS)}"
        )
    rules = plan.rules if plan else Rules()
    if foam_mm is not None:
        rules = replace(rules, foam=1e-3 * foam_mm)
    if overhang is not None:
        rules = replace(rules, most_overhang=overhang)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("loading", total=None)
        layout, places = cover(
            body,
            chosen,
            count,
            rules=rules,
            link_rules=plan.link_rules if plan else {},
            seed=seed,
            tries=tries or (plan.tries if plan else 3),
            progress=lambda what, done, steps: bar.update(task, description=what, completed=done, total=steps),
        )
    target = output or Path(f"{body.name}.json")
    layout.save(target)
    table = Table(title=f"{body.name}: {len(layout)} cells")
    for heading in (
        "link",
        "cells",
        "patches",
        "area cm²",
        "covered %",
        "edges (open)",
        "gap mm, worst",
        "overhang",
        "foam mm",
        "room mm",
    ):
        table.add_column(heading, justify="left" if heading == "link" else "right")
    for row in report(layout, places):
        table.add_row(
            row.link,
            str(row.cells),
            str(row.patches),
            f"{1e4 * row.coverable_area:.0f}",
            f"{100 * row.coverage:.0f}",
            f"{row.edges} ({row.open_edges})",
            f"{1e3 * row.gap_mean:.2f}, {1e3 * row.gap_worst:.2f}",
            f"{row.overhanging} ({100 * row.worst_overhang:.0f} %)" if row.cells else "",
            f"{1e3 * row.least_foam:.1f}" if row.cells else "",
            f"{1e3 * row.least_room:.1f}" if row.cells else "",
        )
    console.print(table)
    cables = Table(title=f"{len(layout.section_unit_ports)} section-unit cables, {len(layout.studs)} studs")
    for heading in ("section unit", "port", "plugs into", "length min to max m", "worst stretch %"):
        cables.add_column(heading, justify="left" if heading == "plugs into" else "right")
    for place, cable in zip(layout.section_unit_ports, layout.cables, strict=True):
        cables.add_row(
            str(place.section_unit),
            str(place.port),
            f"cell {layout.id[place.cell]} port {place.cell_port} ({layout.links[layout.link[place.cell]]})",
            f"{cable.length_min_m:.3f} to {cable.length_max_m:.3f}",
            f"{100 * cable.worst_stretch:.1f}",
        )
    console.print(cables)
    console.print(f"layout written to {target}")
    if picture is not None:
        from robotskin.layout.picture import save_picture

        with console.status("drawing"):
            save_picture(layout, body, picture)
        console.print(f"picture written to {picture}")
