# SPDX-License-Identifier: Apache-2.0
"""A verdict on a skin's wiring in plain sentences."""

from __future__ import annotations

from collections.abc import Sequence

from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits.verdict import PartVerdict, Verdict

NAMED = 4
"""Names that a sentence lists before it says how many more there are."""


def sentences(verdict: Verdict) -> list[str]:
    """What the skin can do, what limits it, and what would help."""
    network, tightest = verdict.network, verdict.parts[0]
    units = len({(cable.group, cable.unit) for cable in network.cables})
    told = [
        f"{network.name}: {count(len(network), 'cell')} in {count(len(verdict.parts), 'connected part')}, "
        f"{count(len(network.cables), 'cable')} on {count(units, 'section unit')}.",
        f"At {verdict.rate_hz:g} Hz a cable, or a link between two cells, carries {verdict.cells_per_line} cells.",
    ]
    if verdict.tree_rate_hz >= verdict.rate_hz:
        told.append(f"Every cell can be heard at {verdict.rate_hz:g} Hz; the most is {verdict.tree_rate_hz:.0f} Hz.")
    elif verdict.any_rate_hz >= verdict.rate_hz:
        told.append(
            f"Not every cell can be heard at {verdict.rate_hz:g} Hz with one parent a cell: {verdict.tree_rate_hz:.0f} "
            f"Hz is the most. Split over all paths it would be {verdict.any_rate_hz:.0f} Hz."
        )
    elif verdict.any_rate_hz > 0:
        told.append(
            f"No routing hears every cell at {verdict.rate_hz:g} Hz: the most is {verdict.any_rate_hz:.0f} Hz, "
            f"with one parent a cell {verdict.tree_rate_hz:.0f} Hz."
        )
    else:
        silent = sum(part.cells for part in verdict.parts if part.any_rate_hz == 0)
        told.append(f"{count(silent, 'cell')} cannot be heard at all: no cable leads to them.")
    told.append(limit(network, tightest))
    if verdict.cable:
        ((cell, port),) = verdict.cable.ends
        told.append(
            f"One more cable helps most at {end(network, cell, port)}: these cells then reach "
            f"{verdict.cable.rate_hz:.0f} Hz."
        )
    else:
        told.append("One more cable does not help: these cells have no free port from which it would add a way out.")
    if verdict.bridge:
        first, second = (end(network, cell, port) for cell, port in verdict.bridge.ends)
        far = verdict.bridge.distance_m
        length = "across links" if far is None else f"{1000 * far:.0f} mm apart"
        told.append(f"One more bridge helps most from {first} to {second} ({length}): {verdict.bridge.rate_hz:.0f} Hz.")
    else:
        told.append("One more bridge does not help.")
    return told


def limit(network: CellNetwork, part: PartVerdict) -> str:
    """The cut that limits a part."""
    cut = part.cut
    where = names(list(dict.fromkeys(network.patch_name(int(cell)) for cell in cut.cells)))
    if not cut.lines:
        return f"The tightest place: {count(len(cut.cells), 'cell')} of {where} without a cable."
    lines = [f"{network.cables[index]} at {network.cell_name(network.cables[index].cell)}" for index in cut.cables]
    lines += [
        f"the link from {end(network, int(a), int(p))} to {end(network, int(b), int(q))}" for a, p, b, q in cut.links
    ]
    share = float(cut.cells_per_line)
    return (
        f"The tightest place: {count(len(cut.cells), 'cell')} of {where} behind {count(cut.lines, 'line')}, "
        f"{share:.4g} cells a line, {cut.rate_hz:.0f} Hz: {names(lines)}."
    )


def end(network: CellNetwork, cell: int, port: int) -> str:
    """A port as a person finds it."""
    return f"port {port} of {network.cell_name(cell)} on {network.patch_name(cell)}"


def names(listed: Sequence[str]) -> str:
    """A list that does not grow without end."""
    if len(listed) <= NAMED:
        return ", ".join(listed)
    return ", ".join(listed[:NAMED]) + f" and {len(listed) - NAMED} more"


def count(number: int, noun: str) -> str:
    """A number of things."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
