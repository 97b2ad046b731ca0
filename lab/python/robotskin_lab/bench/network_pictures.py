# SPDX-License-Identifier: Apache-2.0
"""The distributions behind the figures of the network's benchmark, drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robotskin_lab.bench.network_balance import Balance
from robotskin_lab.bench.network_faults import KINDS, Healing
from robotskin_lab.bench.network_naive import PLACEMENTS
from robotskin_lab.bench.network_set import COMPACT, PORTS
from robotskin_lab.bench.network_size import Growth

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OURS, NAIVE, LIMIT = "#3d6ea5", "#c9ccd3", "#d62839"


def tidy(axes: Axes, title: str, x: str, y: str) -> None:
    """Labels, and no frame that tells nothing."""
    axes.set_title(title, fontsize=9)
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.spines[["top", "right"]].set_visible(False)


def draw_balance(balances: list[Balance], path: Path) -> None:
    """Fullest cable before and after, its way there over time, and the depth that it costs."""
    from matplotlib.figure import Figure

    compact = [one for one in balances if one.run.kind in COMPACT]
    figure = Figure(figsize=(12, 3.6), layout="constrained")
    first, second, third = figure.subplots(1, 3)
    for colour, name, values in (
        (NAIVE, "first-arrival trees", [one.naive / one.best[0] for one in compact]),
        (OURS, "balanced by the network", [one.run.parts[0].fullest / one.best[0] for one in compact]),
    ):
        ordered = np.sort(values)
        first.step(ordered, np.arange(1, len(ordered) + 1) / len(ordered), color=colour, label=name, linewidth=2)
    first.axvline(1.02, color=LIMIT, linewidth=0.8, linestyle="--")
    first.legend(fontsize=7, frameon=False, loc="lower right")
    tidy(first, f"{len(compact)} compact skins", "fullest cable / least possible", "share of skins")
    for one in compact[:: max(1, len(compact) // 150)]:
        times, fullest = zip(*one.run.history, strict=True)
        second.plot(times, np.array(fullest) / one.best[0], color=OURS, alpha=0.25, linewidth=0.8)
    second.axhline(1.02, color=LIMIT, linewidth=0.8, linestyle="--")
    tidy(second, "from power-on to balance", "s", "fullest cable / least possible")
    extra = [one.run.depth - one.run.least_depth for one in compact]
    bound = [one.even_depth - one.run.least_depth for one in compact]
    bins = np.arange(-0.5, max([*extra, *bound, 4]) + 1.5)
    third.hist([extra, bound], bins=bins.tolist(), color=[OURS, NAIVE], label=["network", "least for even loads"])
    third.legend(fontsize=7, frameon=False)
    tidy(third, "hops of the deepest cell over the fewest possible", "hops", "skins")
    figure.savefig(path, dpi=110)


def draw_recovery(healings: list[Healing], path: Path) -> None:
    """Recovery by kind of fault, every run a dot."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 3.8), layout="constrained")
    axes = figure.subplots()
    kinds = [kind for kind in KINDS if any(healing.kind == kind for healing in healings)]
    for place, kind in enumerate(kinds):
        values = [healing.recovery_ms for healing in healings if healing.kind == kind]
        spread = place + 0.7 * (np.arange(len(values)) * 0.618 % 1 - 0.5)
        axes.scatter(spread, values, s=7, color=OURS, alpha=0.5, linewidths=0)
    axes.axhline(10, color=LIMIT, linewidth=0.8, linestyle="--")
    axes.set_xticks(range(len(kinds)), kinds)
    tidy(
        axes, f"{len(healings)} runs with one fault each (published: 40 ms)", "", "ms until every cell has a way again"
    )
    figure.savefig(path, dpi=110)


def draw_size(growths: list[Growth], path: Path) -> None:
    """The longest cylinder by number of cables and their placement."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 3.4), layout="constrained")
    for axes, placement in zip(figure.subplots(1, len(PLACEMENTS), sharey=True), PLACEMENTS, strict=True):
        for place, ports in enumerate(PORTS):
            mine = [one for one in growths if one.ports == ports and one.placement == placement]
            for shift, colour, values in (
                (-0.28, NAIVE, [one.naive for one in mine]),
                (0.0, OURS, [one.ours for one in mine]),
                (0.28, LIMIT, [one.most for one in mine]),
            ):
                if values:
                    axes.bar(place + shift, np.median(values), width=0.26, color=colour)
                    axes.vlines(place + shift, min(values), max(values), color="black", linewidth=0.8)
        axes.set_xticks(range(len(PORTS)), [str(ports) for ports in PORTS])
        tidy(axes, f"cables at {placement}", "cables", "cells of the longest cylinder")
    figure.suptitle("grey: first-arrival trees, blue: the network, red: any routing; bars the middle, lines the range")
    figure.savefig(path, dpi=110)
