# SPDX-License-Identifier: Apache-2.0
"""Everything known about one cell, as a piece of HTML."""

from html import escape

import numpy as np

from robotskin.layout import Layout
from robotskin.skin import Health
from robotskin.viewer.colours import HEALTH_COLOURS, health_word
from robotskin.viewer.legend import PADDING, css
from robotskin.viewer.network import cable_names
from robotskin.viewer.network_view import NetworkReading
from robotskin.viewer.port_table import port_table
from robotskin.viewer.session_view import Integers, SkinReading

NOTHING_CHOSEN = f'<div style="{PADDING};font-size:12px;opacity:.65">Click a cell to see what it measures.</div>'


def cell_card(
    cell: int | None, layout: Layout, cable: Integers, reading: SkinReading, network: NetworkReading | None = None
) -> str:
    """The identity, health, nine channels and, where they are seen, ports of a cell; an invitation where it is None."""
    if cell is None:
        return NOTHING_CHOSEN
    health = Health(int(reading.health[cell]))
    word = health_word(health)
    age = float(reading.age_s[cell])
    force = [float(newton) for newton in reading.normal_force[cell]]
    rows = [
        *([("ill", reading.ill[cell])] if cell in reading.ill else []),
        ("last heard", f"{age * 1e3:.0f} ms ago" if np.isfinite(age) else "none yet"),
        *_of("force", reading, ("force, all three sensors", f"{sum(force):.2f} N")),
        *_of("force", reading, ("each of them", f"{_row(force, 2)} N")),
        *_of("proximity", reading, ("nearest thing", _distance(float(reading.distance[cell])))),
        *_of("proximity", reading, ("proximity, of full scale", f"{float(reading.proximity[cell]):.2%}")),
        *_of("acceleration", reading, ("acceleration x, y, z", f"{_row(reading.acceleration[cell], 2)} m/s²")),
        *_of("temperature", reading, ("temperature 1, 2", f"{_row(reading.temperature[cell], 1)} °C")),
        *(
            (column.replace("_", " "), f"{_row(np.atleast_1d(values[cell]), 2)} {unit}")
            for column, (values, unit) in reading.further.items()
        ),
    ]
    # Last values of a cell that is not alive are shown, but never as if they were fresh.
    faded = "" if health is Health.alive else "opacity:.55;"
    head = (
        f'<div style="display:flex;justify-content:space-between;font-weight:600;margin-bottom:3px">'
        f'<span data-cell="{cell}">Cell {cell}</span>'
        f'<span data-health="{word}" style="color:{css(HEALTH_COLOURS[health])}">{word}</span></div>'
    )
    values = f'<div style="{faded}">{table_rows(rows)}</div>'
    ports = "" if network is None else port_table(cell, layout, network)
    return f'<div style="{PADDING};font-size:12px">{head}{place_rows(cell, layout, cable)}{values}{ports}</div>'


def _of(sensor: str, reading: SkinReading, row: tuple[str, str]) -> list[tuple[str, str]]:
    """The row of a sensor, where the skin has it."""
    return [row] if sensor in reading.sensors else []


def place_rows(cell: int, layout: Layout, cable: Integers) -> str:
    """Where a cell sits and how it is wired; `cable` (N,) is the one each cell reports through."""
    through = cable_names(layout)[int(cable[cell])] if cable[cell] >= 0 else "–"
    neighbours = ", ".join(_number(int(neighbour)) for neighbour in layout.neighbours[cell, :, 0])
    return table_rows(
        [
            ("link", layout.links[layout.link[cell]]),
            ("group", str(layout.group[cell])),
            ("id in its group", str(layout.id[cell])),
            ("patch", _number(int(layout.patch[cell]))),
            ("cable (unit:port)", through),
            ("neighbours, ports 1 to 4", neighbours),
        ]
    )


def table_rows(rows: list[tuple[str, str]]) -> str:
    """Names on the left, values on the right, digits under digits."""
    return "".join(
        '<div style="display:flex;justify-content:space-between;gap:8px;line-height:1.55">'
        f'<span style="opacity:.65">{escape(name)}</span>'
        f'<span style="font-variant-numeric:tabular-nums;text-align:right">{escape(value)}</span></div>'
        for name, value in rows
    )


def _number(index: int) -> str:
    return "–" if index < 0 else str(index)


def _row(values: object, digits: int) -> str:
    return "  ".join(f"{float(value):.{digits}f}" for value in np.asarray(values))


def _distance(metres: float) -> str:
    return f"{metres * 100:.1f} cm" if np.isfinite(metres) else "nothing near"
