# SPDX-License-Identifier: Apache-2.0
"""The skins whose loads stayed uneven, named as a person repeats them, and why."""

from __future__ import annotations

from robotskin.layout.network_limits import bottleneck
from robotskin_lab.bench.network_balance import EVEN, EXTRA_HOPS, FAIR, Balance
from robotskin_lab.bench.network_set import COMPACT, skins

HEADER = ("skin", "fullest", "ideal", "ratio", "least", "found", "to it", "hops", "why")


def misses(balances: list[Balance]) -> list[str]:
    """Lines of a table, and what never formed.

    Compact skins beyond 1.02 of ceil(N / K), the worst first, then other skins beyond 1.10 of the best known trees, by
    their worst part. `least`: cells that the fullest cable of no trees within the allowed depth undercuts; `found`:
    those of the best such trees that were found; `to it`: the fullest over that least, or over the best known of any
    depth where that is more.
    """
    told = [f"{name(one)}: not formed" for one in balances if one.run.formation_ms < 0]
    compact = sorted(
        (one for one in balances if one.run.kind in COMPACT and one.ratio > EVEN), key=lambda one: -one.ratio
    )
    rows = [compact_row(one) for one in compact]
    rows += [
        other_row(one) for one in balances if one.run.kind not in COMPACT and max(one.ratios(), default=0.0) > FAIR
    ]
    if rows:
        widths = [max(len(row[column]) for row in [HEADER, *rows]) for column in range(len(HEADER))]
        told += [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in [HEADER, *rows]
        ]
    return told


def name(one: Balance) -> str:
    """Kind, cables and seed: `skins("sheet", 3, 17)` is `sheet:3:17`."""
    return f"{one.run.kind}:{one.run.ports}:{one.run.seed}"


def compact_row(one: Balance) -> tuple[str, ...]:
    """Of a compact skin."""
    ideal, extra = one.run.parts[0].ideal, one.run.depth - one.run.least_depth
    if one.best[0] > ideal:
        why = f"proven: a cable is walled in, {one.best[0]} at any depth"
    elif one.proven:
        why = f"proven: needs {one.even_depth - one.run.least_depth} hops"
    else:
        why = "stalled at the cap" if extra >= EXTRA_HOPS else "stalled"
    return (*measured(one, 0), why)


def other_row(one: Balance) -> tuple[str, ...]:
    """Of a skin of several patches: its worst part against the best known trees."""
    part = one.worst_part().part
    cut = float(bottleneck(skins(one.run.kind, one.run.ports, one.run.seed), part).cells_per_line)
    least, best = one.within[part], one.best[part]
    deeper = f" of any depth, proven {least} within +{EXTRA_HOPS}" if least > best else ""
    why = f"part {part}: best known {best}{deeper}, minimum cut {cut:.1f} cells a line"
    return (*measured(one, part), why)


def measured(one: Balance, number: int) -> tuple[str, ...]:
    """All columns but the last, of one part."""
    part, least, found = one.run.parts[number], one.within[number], one.found[number]
    return (
        name(one),
        str(part.fullest),
        str(part.ideal),
        f"{part.fullest / part.ideal:.3f}",
        f">= {least}",
        f"<= {found}",
        f"{part.fullest / max(one.best[number], least):.3f}",
        f"+{one.run.depth - one.run.least_depth}",
    )
