# SPDX-License-Identifier: Apache-2.0
"""A skin's wiring laid flat: its best trees by colour, the cut that limits each part, and how full each cable is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits.report import count
from robotskin.layout.network_limits.verdict import PartVerdict, Verdict

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

MAPS = 6
"""Parts that are drawn, the tightest first."""
SPRING_STEPS = 60
CUT_COLOUR = "#d62839"
LINK_COLOUR = "#b8bcc4"
TREE_COLOURS = ("#3d6ea5", "#e3a13c", "#5a9a6b", "#9468b0", "#c96f4a", "#4fa8b3", "#8f8a3c", "#b0577f")


def flat_map(network: CellNetwork, cells: NDArray[np.int64]) -> Array:
    """(n, 2) places of a connected part's cells on paper, in steps of one link.

    A skin that is flat is drawn as it lies, a bent one so that distances on paper are like hops.
    """
    position = network.position_m[cells]
    if np.ptp(network.link[cells]) == 0 and np.ptp(position[:, 2]) < 1e-9 and np.ptp(network.patch[cells]) == 0:
        span = np.ptp(position[:, :2], axis=0).max()
        return position[:, :2] * (np.sqrt(len(cells)) / max(span, 1e-9))
    place = np.full(len(network), -1)
    place[cells] = np.arange(len(cells))
    links = network.links[place[network.links[:, 0]] >= 0]
    ends = (place[links[:, 0]], place[links[:, 2]])
    graph = csr_matrix((np.ones(len(links)), ends), shape=(len(cells), len(cells)))
    return spring_map(dijkstra(graph, directed=False, unweighted=True))


def spring_map(hops: Array) -> Array:
    """(n, 2) places whose distances are like hop counts, near ones most (Gansner et al., stress majorization, 2004).

    It starts from classical scaling (Torgerson 1952). hops: (n, n).
    """
    number = len(hops)
    if number < 3:
        return np.column_stack([np.arange(number, dtype=float), np.zeros(number)])
    centred = hops**2 - (hops**2).mean(axis=0) - (hops**2).mean(axis=1)[:, None] + (hops**2).mean()
    values, vectors = np.linalg.eigh(-0.5 * centred)
    at = vectors[:, -2:] * np.sqrt(np.maximum(values[-2:], 1e-3))
    weight = 1 / (hops + np.eye(number)) ** 2 * (1 - np.eye(number))
    inverse = np.linalg.pinv(np.diag(weight.sum(axis=1)) - weight)
    for _ in range(SPRING_STEPS):
        apart = np.linalg.norm(at[:, None] - at[None], axis=2)
        pull = -weight * hops / np.maximum(apart, 1e-6)
        at = inverse @ ((pull - np.diag(pull.sum(axis=1))) @ at)
    return at


def draw_map(axes: Axes, verdict: Verdict, part: PartVerdict) -> None:
    """One part: cells in the colour of their tree, cables as rings, the cut in red."""
    from matplotlib.collections import LineCollection

    network = verdict.network
    cells = np.flatnonzero(network.part == network.part[part.cut.cells[0]])
    place = np.full(len(network), -1)
    place[cells] = np.arange(len(cells))
    at = flat_map(network, cells)
    links = network.links[place[network.links[:, 0]] >= 0]
    cut = {tuple(link) for link in part.cut.links.tolist()}
    lines = np.stack([at[place[links[:, 0]]], at[place[links[:, 2]]]], axis=1).reshape(-1, 2, 2)
    is_cut = np.array([tuple(link) in cut for link in links.tolist()], dtype=bool)
    axes.add_collection(LineCollection(list(lines[~is_cut]), colors=LINK_COLOUR, linewidths=0.8, zorder=1))
    axes.add_collection(LineCollection(list(lines[is_cut]), colors=CUT_COLOUR, linewidths=2.5, zorder=2))
    size = min(120.0, 6000.0 / max(len(cells), 20))
    owner = part.forest.owner if part.forest else np.zeros(len(cells), dtype=np.int64)
    colours = [TREE_COLOURS[tree % len(TREE_COLOURS)] if part.forest else "#dddddd" for tree in owner]
    axes.scatter(at[:, 0], at[:, 1], s=size, c=colours, zorder=3, linewidths=0)
    cabled = [cable for cable in range(len(network.cables)) if place[network.roots[cable]] >= 0]
    for cable in cabled:
        edge = CUT_COLOUR if cable in part.cut.cables else "black"
        x, y = at[place[network.roots[cable]]]
        axes.scatter([x], [y], s=2.4 * size, facecolors="none", edgecolors=edge, linewidths=1.8, zorder=4)
    axes.set_title(
        f"{part.patches[0]}{' …' if len(part.patches) > 1 else ''}: {part.cells} cells, {count(part.cables, 'cable')}, "
        f"{part.any_rate_hz:.0f} Hz",
        fontsize=8,
    )
    axes.set_aspect("equal")
    axes.margins(0.08)
    axes.axis("off")


def draw_loads(axes: Axes, verdict: Verdict) -> None:
    """Cells on each cable in the best trees, beside what a cable carries."""
    loads, colours, names = [], [], []
    for part in verdict.parts:
        if part.forest is None:
            continue
        for tree, load in enumerate(part.forest.loads):
            cable = verdict.network.cables[int(part.forest.cables[tree])]
            loads.append(int(load))
            colours.append(TREE_COLOURS[tree % len(TREE_COLOURS)])
            names.append(cable.label)
    axes.bar(range(len(loads)), loads, color=colours, width=0.8)
    axes.axhline(verdict.cells_per_line, color=CUT_COLOUR, linewidth=1)
    axes.set_ylabel("cells")
    axes.set_xlim(-0.7, len(loads) - 0.3)
    if len(loads) <= 40:
        axes.set_xticks(range(len(loads)), names, rotation=90, fontsize=7)
    else:
        axes.set_xticks([])
    axes.set_title(
        f"cells on each cable (section unit:port), best trees; red: {verdict.cells_per_line} a cable at "
        f"{verdict.rate_hz:g} Hz",
        fontsize=8,
    )
    axes.spines[["top", "right"]].set_visible(False)


def save_picture(verdict: Verdict, path: Path) -> None:
    """Draw the tightest parts and all loads into a picture; the name's ending tells the format."""
    from matplotlib.figure import Figure

    drawn = verdict.parts[:MAPS]
    columns = min(3, len(drawn))
    rows = -(-len(drawn) // columns)
    figure = Figure(figsize=(12, 3.9 * rows + 2.4), layout="constrained")
    grid = figure.add_gridspec(rows + 1, columns, height_ratios=[*[3.6] * rows, 2.0])
    for number, part in enumerate(drawn):
        draw_map(figure.add_subplot(grid[divmod(number, columns)]), verdict, part)
    draw_loads(figure.add_subplot(grid[rows, :]), verdict)
    figure.suptitle(
        f"{verdict.network.name}: every cell heard at {verdict.tree_rate_hz:.0f} Hz at most "
        f"(any routing {verdict.any_rate_hz:.0f} Hz); rings are cables, what limits a part is red",
        fontsize=10,
    )
    figure.savefig(path, dpi=110)
