# SPDX-License-Identifier: Apache-2.0
"""Touches of a standing robot as they are drawn: where, how hard, how long, and how long until the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotskin.layout import Layout
from robotskin_lab.bench.balance_cells import inner_cells

FORCE_N = (5.0, 40.0)
TOUCH_S, PAUSE_S = (0.1, 1.2), (0.2, 1.0)
LARGEST_IMPULSE_NS = 10.0
"""Of touches that are shorter than `SHORT_S`."""
SHORT_S = 0.25


@dataclass(frozen=True)
class DrawnTouch:
    """A cell that is pushed against its normal with a force for some seconds, and the pause after it."""

    cell: int
    force_n: float
    seconds: float
    pause_s: float


def touched_links(layout: Layout) -> list[str]:
    """Links that random touches are drawn on: all but the legs, where a cell is far enough from the border."""
    return [link for link in layout.links if "leg" not in link and len(inner_cells(link))]


def drawn_touch(draw: np.random.Generator, links: Sequence[str]) -> DrawnTouch:
    """One touch: a link, a cell of it, and the rest, each as likely as any other within its bounds."""
    cell = int(draw.choice(inner_cells(str(draw.choice(links)))))
    seconds, force_n = float(draw.uniform(*TOUCH_S)), float(draw.uniform(*FORCE_N))
    if seconds < SHORT_S:
        force_n = min(force_n, LARGEST_IMPULSE_NS / seconds)
    return DrawnTouch(cell, force_n, seconds, float(draw.uniform(*PAUSE_S)))
