# SPDX-License-Identifier: Apache-2.0
"""What each kind of input takes on the chip: the table by which simulated cells take their time."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from statistics import fmean, median
from typing import Annotated, Any

import typer

from robotskin import firmware
from robotskin.simulator import INPUT_KINDS, LineQuality
from robotskin.world.ideal import cells_take_time
from robotskin_lab.bench.firmware_chip import rig_of
from robotskin_lab.bench.progress import tell
from robotskin_lab.chip import ChipError, ChipImage, build
from robotskin_lab.chip.emulated_cell import Answer
from robotskin_lab.chip.image import SOURCES
from robotskin_lab.chip.meter import Count, Meter
from robotskin_lab.chip.rig import ChipRig

TABLE = SOURCES.parent / "core" / "world" / "network" / "input_cycles.hpp"
COLUMNS = firmware.PORTS + 1
_HEAD = """\
// SPDX-License-Identifier: Apache-2.0
// Cycles of the emulated chip by kind of input and frames started, 0 to 4: means of what the meter has counted.
// Written by `robotskin bench input_cycles --write`, not by hand.
#pragma once

#include "world/network/processor.hpp"

namespace robotskin::world {

// clang-format off
inline constexpr std::array<InputCycles, input_kind_names.size()> input_cycles{{
"""
_TAIL = """\
}};
// clang-format on

}  // namespace robotskin::world
"""

LIKE = {"sent_due": "timer", "tick_due": "wave", "grant": "status"}
"""Kinds that a short run may not bring, and the one that does nearly the same: what is due is done, and then sent."""

Row = list[float]
Counts = dict[str, dict[int, list[Count]]]
"""By kind, by frames started."""


def run(
    *,
    seed: int = 1,
    quick: Annotated[bool, typer.Option(help="A tenth of the time, for a look.")] = False,
    write: Annotated[bool, typer.Option(help="Write the table that the simulated cells read.")] = False,
) -> dict[str, Any]:
    """Count the cycles of each kind of input on the emulated chip, in skins that bring all of them.

    Needs the extra `chip`. Where an input of a kind never started so many frames, what a frame takes is added.
    """
    with cells_take_time():
        counts = counted(seed, 0.1 if quick else 1.0)
    table = filled(counts)
    if write:
        Path(TABLE).write_text(text_of(table))
    figures: dict[str, Any] = {}
    for kind, (zero, one) in table.items():
        met = counts.get(kind, {})
        figures[f"inputs_{kind}"] = sum(len(column) for column in met.values())
        figures[f"cycles_{kind}"] = zero[min(met, default=0)]
        figures[f"cycles_{kind}_one_wait_state"] = one[min(met, default=0)]
    return figures


def counted(seed: int, share: float, image: ChipImage | None = None) -> Counts:
    """What the inputs of some skins took."""
    image = image or build()
    counts: Counts = defaultdict(lambda: defaultdict(list))

    def watched(rig: ChipRig) -> Meter:
        meter = Meter(rig.chip)

        def note(answer: Answer) -> None:
            for count in meter.take():
                counts[rig.external.input_kind][sum(frame is not None for frame in answer[0])].append(count)

        rig.answered = note
        return meter

    tell("input cycles: the busiest cell of a cable")
    rig = rig_of(seed, 11, 6, [(5, 4)], 5, image)
    meter = watched(rig)
    rig.run_ms(250)
    rig.press(16)
    rig.run_ms(50)
    meter.on = True
    rig.run_ms(round(100 * share))
    some = next(int(key) for key in rig.driver.topology()["key"] if key)
    for _ in range(3 + round(9 * share)):
        rig.driver.command("ping", cell=some)
        rig.run_ms(2)
    tell("input cycles: events, a cable of cells that all send them")
    line = LineQuality()
    line.lost_share = 3e-3
    rig = rig_of(seed, 11, 6, [(5, 4)], 5, image, line=line)
    meter = watched(rig)
    rig.run_ms(200)
    rig.driver.command("mode", 1)
    rig.driver.command("threshold", 1, 1)
    rig.run_ms(10)
    meter.on = True
    for turn in range(3 + round(9 * share)):
        rig.press(turn % 5 * 8)
        rig.run_ms(4)
    tell("input cycles: a skin that forms, between two cables that differ")
    rig = rig_of(seed + 1, 7, 5, [(3, 4), (2, 4)], 3, image)
    meter = watched(rig)
    meter.on = True
    rig.run_ms(round(60 + 340 * share))
    tell("input cycles: events, orders and faults")
    line.lost_share, line.bit_error_rate = 1e-3, 5e-5
    rig = rig_of(seed + 2, 3, 3, [(1, 4)], 1, image, line=line)
    meter = watched(rig)
    rig.run_ms(150)
    meter.on = True
    for turn in range(4 + round(16 * share)):
        rig.driver.command("mode", 1)
        rig.driver.command("threshold", 1, 1)
        rig.driver.command("ping")
        for _ in range(3):
            rig.press(turn % 2 * 40)
            rig.run_ms(6)
        port = turn % (firmware.PORTS - 1) + 1
        rig.network.cut(4, port)
        rig.run_ms(6)
        rig.network.mend(4, port)
        rig.run_ms(6)
    tell("")
    return counts


def filled(counts: Counts) -> dict[str, tuple[Row, Row]]:
    """Mean cycles with zero and with one wait state, by kind; a column that was never met by its neighbour.

    One frame more takes what it took where another one started as well, as the first one often goes with other work.

    Raises ChipError for a kind that was never met.
    """
    counts = {kind: counts.get(kind) or counts.get(LIKE.get(kind, kind), {}) for kind in INPUT_KINDS}
    missing = [kind for kind in INPUT_KINDS if not counts[kind]]
    if missing:
        raise ChipError(f"no input of these kinds came to the chip: {', '.join(missing)}")
    rows = {
        kind: tuple(
            {frames: fmean(getattr(count, what) for count in met) for frames, met in counts[kind].items()}
            for what in ("cycles", "cycles_one_wait")
        )
        for kind in INPUT_KINDS
    }
    of_frame = [
        median(
            row[which][frames + 1] - row[which][frames]
            for kind, row in rows.items()
            for frames in row[which]
            if frames > 0 and frames + 1 in row[which]
            for _ in range(min(len(counts[kind][frames]), len(counts[kind][frames + 1])))
        )
        for which in (0, 1)
    ]
    return {kind: (_row(row[0], of_frame[0]), _row(row[1], of_frame[1])) for kind, row in rows.items()}


def _row(met: dict[int, float], of_frame: float) -> Row:
    """All columns; what a frame takes is added to the nearest one that was met, and is never taken away."""
    nearest = [min((abs(known - at), known) for known in met)[1] for at in range(COLUMNS)]
    return [met[known] + max(at - known, 0) * of_frame for at, known in enumerate(nearest)]


def text_of(table: dict[str, tuple[Row, Row]]) -> str:
    """The table as C++."""

    def row(cycles: Row) -> str:
        return "{" + ", ".join(f"{count:.0f}" for count in cycles) + "}"

    lines = [f"    {{{row(zero)}, {row(one)}}},  // {kind}\n" for kind, (zero, one) in table.items()]
    return _HEAD + "".join(lines) + _TAIL
