# SPDX-License-Identifier: Apache-2.0
"""`robotskin simulate`: the network of a skin, with faults, in virtual time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robotskin.cli._ideal_processors import IdealProcessors
from robotskin.cli._waiting import waiting
from robotskin.outputs import writable

if TYPE_CHECKING:
    from robotskin.layout.cell_network import CellNetwork
    from robotskin.simulator import TrialReport

TABLE_WIDTH = 110
STANDARD_PORTS = 3
FAULTS_HELP = """kind:key=value,...@time; several with ; between; random:N@time draws N of any kind by the seed.
Cells count from 0, section units and ports from 1. A wire is named by a port of a cell or of a unit.
A key that has a value here may be left out, and stands for that value then.
"""
SHAPES = ("sheet:COLUMNSxROWS", "cylinder:AROUNDxROWS")


def command(
    layout: Annotated[
        str, typer.Argument(help="A finished layout's name, a layout file, sheet:20x10 or cylinder:11x18.")
    ] = "",
    faults: Annotated[str, typer.Option(help="What goes wrong, and when; --list-faults tells the kinds.")] = "",
    seed: Annotated[int, typer.Option(min=0, help="Repeats the run.")] = 1,
    ports: Annotated[
        int | None,
        typer.Option(min=1, max=600, help="Cables at drawn cells of the rim; by default the layout's own, or 3."),
    ] = None,
    units: Annotated[
        int | None, typer.Option(min=1, max=16, help="Section units to which drawn cables are dealt; 1 by default.")
    ] = None,
    seconds: Annotated[float, typer.Option(min=0.01, help="Virtual time.")] = 1.0,
    rate: Annotated[int, typer.Option(help="Samples a second of each cell: 0, 63, 125 or 250.")] = 250,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the figures here.", dir_okay=False, callback=writable)
    ] = None,
    list_faults: Annotated[bool, typer.Option("--list-faults", help="Print the kinds of faults and end.")] = False,
    ideal_processors: IdealProcessors = False,
) -> None:
    """Run the network of a skin with faults in virtual time, every cell with its own firmware.

    The same seed and faults give the same run, to the byte: the log hash says so. Exit status 0 means that at the end
    every cell in reach has a way to a section unit; 1 that one has not.

    Examples:

    robotskin simulate ur5 --faults "crash:cell=40@300ms; reboot:cell=7,off=2ms@500ms"

    robotskin simulate sheet:20x10 --ports 3 --faults "random:4@400ms" --seed 7

    robotskin simulate cylinder:11x18 --ports 4 --units 2 --faults "stop:unit=1,for=50ms@400ms" --json run.json
    """
    from rich.markup import escape
    from rich.table import Table

    from robotskin.cli._terminal import terminal
    from robotskin.errors import InputError
    from robotskin.figures import write_figures
    from robotskin.simulator import fault_help
    from robotskin.world.trial import figures_of, run_trial

    console = terminal()
    if console.width < TABLE_WIDTH:
        console = terminal(TABLE_WIDTH)
    if list_faults:
        console.print(FAULTS_HELP)
        table = Table(box=None, padding=(0, 2, 0, 0), show_header=False)
        for line in fault_help().splitlines():
            fault, _, meaning = line.partition("  ")
            table.add_row(escape(fault), escape(meaning))
        console.print(table, highlight=False)
        return
    rates = (0, 63, 125, 250)
    if rate not in rates:
        raise InputError(f"--rate {rate}: choose from {', '.join(map(str, rates))}")
    skin, remarks = skin_of(layout, ports, units, seed)
    with waiting(f"{len(skin)} cells") as tell:
        report = run_trial(
            skin,
            seconds,
            seed,
            faults,
            rate_hz=rate,
            progress=lambda time_s, _: tell(f"{len(skin)} cells", time_s / seconds),
        )
    for remark in remarks:
        console.print(f"Note: {remark}.", highlight=False)
    show(console, skin, report, seed)
    if json_file is not None:
        write_figures(json_file, seed, figures_of(report))
    if not report.whole or report.formation_ms < 0:
        raise typer.Exit(1)


def skin_of(layout: str, ports: int | None, units: int | None, seed: int) -> tuple[CellNetwork, tuple[str, ...]]:
    """The cells and cables that a user means, and what had to be assumed about them.

    Raises:
        InputError: neither a finished layout, nor a shape, nor a file; or no cable, or more than the rim has room for;
            or more section units than cables.
        LayoutFileError: a file that is no skin, or does not say which port is plugged into which.
    """
    from random import Random

    import numpy as np

    from robotskin import layout as layouts
    from robotskin.errors import InputError
    from robotskin.layout import network_shapes
    from robotskin.layout.network_limits import named_networks

    remarks: tuple[str, ...] = ()
    kind, _, size = layout.partition(":")
    if kind in ("sheet", "cylinder"):
        numbers = size.split("x")
        if len(numbers) != 2 or not all(number.isdigit() and 0 < int(number) <= 400 for number in numbers):
            raise InputError(f"layout {layout!r}: {' or '.join(SHAPES)}, such as sheet:20x10; each 1 to 400")
        columns, rows = (int(number) for number in numbers)
        links, position = network_shapes.lattice(columns, columns * rows, wrapped=kind == "cylinder")
        skin = network_shapes.assemble(kind, columns * rows, links, position)
        ports = ports or STANDARD_PORTS
    else:
        known = layouts.finished_names()
        if layout not in known and not Path(layout).is_file():
            raise InputError(f"layout {layout!r}: choose from {', '.join(known)}, {', '.join(SHAPES)}, or name a file")
        (found,) = named_networks(layout)
        skin, remarks = found.network, found.remarks
    if ports is None:
        if units is not None:
            raise InputError(f"--units {units}: {layout} has its own cables; --ports draws others")
        if not skin.cables:
            raise InputError(f"layout {layout!r}: it states no cable; --ports draws some")
        return skin, remarks
    if units is not None and units > ports:
        raise InputError(f"--units {units}: there are {ports} cables, --ports, and each unit needs one")
    free = skin.neighbours[:, :, 0] < 0
    rim = [int(cell) for cell in np.flatnonzero(free.any(axis=1))]
    if ports > len(rim):
        raise InputError(f"--ports {ports}: {len(rim)} cells of {layout} have a free port")
    Random(seed).shuffle(rim)
    ends = [(cell, int(np.flatnonzero(free[cell])[0]) + 1) for cell in rim[:ports]]
    return skin.with_cables(ends, units=units or 1), ()


def show(console: object, skin: CellNetwork, report: TrialReport, seed: int) -> None:
    """Print what happened."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    assert isinstance(console, Console)
    formed = "never formed" if report.formation_ms < 0 else f"formed after {report.formation_ms:.2f} ms"
    named = "" if report.named_ms < 0 else f", all named after {report.named_ms:.2f} ms"
    console.print(f"{len(skin)} cells of {skin.name}, {len(skin.cables)} cables: {formed}{named}")
    if report.outcomes:
        table = Table(title="Faults")
        for heading in ("fault", "cells cut off", "ways again after ms", "all joined after ms", "healed"):
            table.add_column(heading, justify="left" if heading in ("fault", "healed") else "right", overflow="fold")
        for number, outcome in enumerate(report.outcomes, start=1):
            # What the next fault came upon goes on in that one's row.
            unhealed = Text("no", "bold red") if number == len(report.outcomes) else "next came first"
            table.add_row(
                str(outcome.fault),
                str(outcome.cells_cut_off),
                f"{outcome.recovery_ms:.2f}",
                f"{outcome.rejoin_ms:.2f}",
                "yes" if outcome.healed else unhealed,
            )
        console.print(table)
    loads = "; ".join(", ".join(map(str, unit)) for unit in report.port_loads)
    console.print(
        f"cells by port: {loads}; "
        f"at most {report.depth_max} hops, on average {report.extra_depth_mean:.2f} over the fewest"
    )
    if report.samples_heard:
        console.print(
            f"{report.samples_sent} samples sent, {report.samples_lost} lost; latency {report.latency_mean_ms:.2f} ms, "
            f"p99 {report.latency_p99_ms:.2f} ms; longest silence of a steady cell {report.host_gap_ms:.2f} ms"
        )
    else:
        console.print(f"{report.samples_sent} samples sent, none heard")
    state = "whole" if report.whole else "[bold red]not whole[/]"
    if report.cells_in_reach < len(skin):
        state += f", [bold]{report.cells_in_reach} of {len(skin)} cells in reach of a cable[/]"
    console.print(f"after {report.seconds:g} s: {state}; seed {seed}, log hash {report.log_hash:016x}", markup=True)
