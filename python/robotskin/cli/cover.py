# SPDX-License-Identifier: Apache-2.0
"""Cover a robot with skin cells and write the layout."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from robotskin.cli._terminal import terminal
from robotskin.cli._waiting import waiting

TABLE_WIDTH = 110
"""Columns below which the tables would be cut to pieces."""


def command(
    robot: Annotated[str, typer.Argument(help="Name of a robot or of a finished layout, or path of a URDF.")],
    links: Annotated[
        str | None,
        typer.Option(help="Links to cover, with commas between; by default the robot's plan, or all that move."),
    ] = None,
    cells: Annotated[
        int | None, typer.Option(min=1, help="Cells in all; by default as the robot's plan says, or as many as fit.")
    ] = None,
    area: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LINK:CELLS:X,Y,Z[:DEGREES]",
            help="Exactly so many cells of a link come first that look along this direction of its frame, within 30 "
            "degrees or as many as are given. May be given several times.",
        ),
    ] = None,
    least: Annotated[
        int | None, typer.Option(min=1, help="Cells that each covered link keeps, as far as so many fit on it.")
    ] = None,
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
    from robotskin.cli._covered import area_lines, short_links
    from robotskin.layout import finished
    from robotskin.layout.area_text import read_area
    from robotskin.layout.covering import cover, moving_links
    from robotskin.layout.places import Rules
    from robotskin.layout.plans import PLANS
    from robotskin.layout.report import report
    from robotskin.outputs import require_writable

    console = terminal()
    if console.width < TABLE_WIDTH:
        console = terminal(TABLE_WIDTH)
    require_writable("--output", output, (".json", ".json.gz", ".gz"))
    require_writable("--picture", picture, (".png",))
    asked = [read_area(text) for text in area or ()]
    # A skin for a purpose is asked for by its own name.
    other = PLANS[robot].robot if robot in PLANS else ""
    body = robots.load(other or robot)
    plan = PLANS.get(robot if other else body.name)
    named_links = tuple(dict.fromkeys(link.strip() for link in links.split(","))) if links else ()
    chosen = named_links or (plan.links if plan else moving_links(body))
    # The number of a plan is that of the links of the plan.
    count = cells or (plan.cells if plan and not links else None)
    rules = plan.rules if plan else Rules()
    if foam_mm is not None:
        rules = replace(rules, foam=1e-3 * foam_mm)
    if overhang is not None:
        rules = replace(rules, most_overhang=overhang)
    with waiting("loading") as tell:
        layout, places = cover(
            body,
            chosen,
            count,
            rules=rules,
            link_rules=plan.link_rules if plan else {},
            areas=(*(plan.areas if plan and not links else ()), *asked),
            worn=finished(plan.worn) if plan and plan.worn and not links else None,
            least=least or 0,
            seed=seed,
            tries=tries or (plan.tries if plan else 3),
            progress=lambda what, done, steps: tell(what, done / steps if steps else None),
        )
    target = output or Path(f"{robot if other else body.name}.json")
    # A robot with a name is found again by it; another one by its file.
    named = body.name == (other or robot) and body.source is not None
    layout = replace(layout, urdf="" if named or body.source is None else str(body.source))
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
        table.add_column(
            heading, justify="left" if heading == "link" else "right", overflow="fold", no_wrap=heading == "link"
        )
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
    cables = Table(
        title=f"{len(layout.section_unit_ports)} section-unit cables; {len(layout.studs)} studs hold the patches"
    )
    for heading in ("section unit", "port", "plugs into", "length min to max m", "worst stretch %"):
        cables.add_column(heading, justify="left" if heading == "plugs into" else "right")
    for place, cable in zip(layout.section_unit_ports, layout.cables, strict=True):
        cables.add_row(
            str(place.group),
            str(place.port),
            f"cell {layout.id[place.cell]} port {place.cell_port} ({layout.links[layout.link[place.cell]]})",
            f"{cable.length_min_m:.3f} to {cable.length_max_m:.3f}",
            f"{100 * cable.worst_stretch:.1f}",
        )
    console.print(cables)
    for line in (*area_lines(asked, layout), *short_links(chosen, layout, places, least or 0)):
        console.print(line, highlight=False, soft_wrap=True)
    console.print(
        f"layout written to {target}; next: robotskin check {target}, robotskin run {robot} --layout {target}",
        highlight=False,
        soft_wrap=True,
    )
    if picture is not None:
        from robotskin.layout.picture import save_picture

        with waiting("drawing"):
            save_picture(layout, body, picture)
        console.print(f"picture written to {picture}")
