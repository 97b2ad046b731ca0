"""The skins whose loads stayed uneven, named as a person repeats them, and why."""

from __future__ import annotations

from robotskin.bench.network_balance import EVEN, EXTRA_HOPS, FAIR, Balance
from robotskin.bench.network_set import COMPACT, skins
from robotskin.layout.network_limits import bottleneck

HEADER = ("skin", "fullest", "ideal", "ratio", "possible", "to it", "hops", "why")


def misses(balances: list[Balance]) -> list[str]:
    """Lines of a table, and what never formed.

    Compact skins beyond 1.02 of ceil(N / K), the worst first, beside what no trees within the allowed depth undercut;
    then other skins beyond 1.10 of the best known trees, with the minimum cut of their worst part.
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
    within = one.within[0]
    loads = (str(one.fullest), str(ideal), f"{one.ratio:.3f}", f">= {within}", f"{one.fullest / within:.3f}")
    return (name(one), *loads, f"+{extra}", why)


def other_row(one: Balance) -> tuple[str, ...]:
    """Of a skin of several patches: its worst part against the best known trees."""
    part = one.worst_part()
    best, within = one.best[part.part], one.within[part.part]
    cut = float(bottleneck(skins(one.run.kind, one.run.ports, one.run.seed), part.part).cells_per_line)
    proven = f", proven: {within} within {EXTRA_HOPS} hops" if within > best else ""
    why = f"part {part.part}: best known {best}{proven}, minimum cut {cut:.1f} cells a line"
    extra = one.run.depth - one.run.least_depth
    possible = max(best, within)
    return (
        name(one),
        str(part.fullest),
        str(part.ideal),
        f"{part.fullest / part.ideal:.3f}",
        str(possible),
        f"{part.fullest / possible:.3f}",
        f"+{extra}",
        why,
    )
