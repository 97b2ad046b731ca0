# SPDX-License-Identifier: Apache-2.0
"""One skin's trees as they formed and as they settled: every cell in the colour of its cable, joined to its parent."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits.picture import TREE_COLOURS, flat_map
from robotskin.simulator import NetworkTrial
from robotskin_lab.bench.network_runs import NAIVE_FROM_S, loads_of, run_to_balance, trial_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def parents_of(network: CellNetwork, trial: NetworkTrial) -> NDArray[np.int64]:
    """(N,) each cell's parent, -1 for a cell whose parent is a section unit, -2 without one."""
    parents = np.full(len(network), -2, dtype=np.int64)
    for cell in range(len(network)):
        port = trial.network.cell_parent_port(cell)
        if port:
            parents[cell] = network.neighbours[cell, port - 1, 0]
    return parents


def owners_of(network: CellNetwork, parents: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) the cable that each cell reports through, -1 without one."""
    cable_at = {int(root): number for number, root in enumerate(network.roots)}
    owner = np.full(len(network), -1, dtype=np.int64)
    for cell in range(len(network)):
        at, hops = cell, 0
        while parents[at] >= 0 and hops <= len(network):
            at, hops = int(parents[at]), hops + 1
        if parents[at] == -1:
            owner[cell] = cable_at.get(at, -1)
    return owner


def draw_panel(axes: Axes, network: CellNetwork, trial: NetworkTrial, title: str) -> None:
    """The trees at this moment."""
    from matplotlib.collections import LineCollection

    at = flat_map(network, np.arange(len(network)))
    parents = parents_of(network, trial)
    owner = owners_of(network, parents)
    branches = np.flatnonzero(parents >= 0)
    colours = [TREE_COLOURS[tree % len(TREE_COLOURS)] if tree >= 0 else "#dddddd" for tree in owner]
    lines = np.stack([at[branches], at[parents[branches]]], axis=1)
    axes.add_collection(LineCollection(list(lines), colors=[colours[cell] for cell in branches], linewidths=1.6))
    axes.scatter(at[:, 0], at[:, 1], s=26, c=colours, linewidths=0, zorder=2)
    roots = at[network.roots]
    axes.scatter(roots[:, 0], roots[:, 1], s=90, facecolors="none", edgecolors="black", linewidths=1.8, zorder=3)
    loads = " + ".join(str(load) for load in loads_of(network, trial))
    axes.set_title(f"{title}: {loads} cells", fontsize=9)
    axes.set_aspect("equal")
    axes.margins(0.05)
    axes.axis("off")


def draw_trees(network: CellNetwork, seed: int, path: Path) -> None:
    """Draw a skin of one part before and after balance."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.6), layout="constrained")
    first, second = figure.subplots(1, 2)
    trial = trial_of(network, seed)
    trial.run_until(NAIVE_FROM_S)
    draw_panel(first, network, trial, f"{1e3 * NAIVE_FROM_S:.0f} ms after power-on, shortest paths")
    _, history = run_to_balance(network, trial)
    draw_panel(second, network, trial, f"{1e3 * history[-1][0]:.0f} ms, balanced")
    figure.suptitle("cells in the colour of their cable (ringed), each joined to its parent", fontsize=9)
    figure.savefig(path, dpi=100)
