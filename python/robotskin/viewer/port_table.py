# SPDX-License-Identifier: Apache-2.0
"""The four ports of one cell of a living network, as HTML: what is there, whether it works, what was damaged."""

from dataclasses import dataclass

from robotskin.layout import Layout
from robotskin.viewer.network import cable_names
from robotskin.viewer.network_view import NetworkReading

PARENT, CHILD, RESERVE = "parent", "child", "reserve"

ROLE_WORDS = {PARENT: "way out", CHILD: "way in", RESERVE: "spare"}


@dataclass(frozen=True)
class PortState:
    """What is so at one port of a cell."""

    port: int
    """1 to 4."""
    neighbour: str
    """Cell and its port, or the cable; empty at a free port."""
    trouble: str = ""
    """Why nothing comes through; empty where the wire works, and at a free port."""
    role: str = ""
    """Of the neighbour, while the wire works: `PARENT`, `CHILD` or `RESERVE`."""
    damaged: int | None = None
    """Frames that arrived damaged here since the cell started; None at a free port."""
    damaged_there: int | None = None
    """The same at the other end; None where that is no cell."""


def port_states(cell: int, layout: Layout, reading: NetworkReading) -> list[PortState]:
    """The ports 1 to 4 of a cell at one moment of its network."""
    plugs = [(place.cell, place.cell_port) for place in layout.section_unit_ports]
    cable_at = dict(zip(plugs, cable_names(layout), strict=True))
    states = []
    for port in range(1, layout.neighbours.shape[1] + 1):
        other, other_port = (int(part) for part in layout.neighbours[cell, port - 1])
        cable = cable_at.get((cell, port))
        if other < 0 and cable is None:
            states.append(PortState(port, ""))
            continue
        trouble = ""
        if reading.cut[cell, port - 1] or (other >= 0 and reading.cut[other, other_port - 1]):
            trouble = "cut"
        elif not reading.alive[cell]:
            trouble = "cell dead"
        elif other >= 0 and not reading.alive[other]:
            trouble = "neighbour dead"
        role = ""
        if not trouble:
            child = other >= 0 and reading.parent_port[other] == other_port
            role = PARENT if reading.parent_port[cell] == port else CHILD if child else RESERVE
        states.append(
            PortState(
                port,
                f"cable {cable}" if other < 0 else f"cell {other}, port {other_port}",
                trouble,
                role,
                int(reading.damaged[cell, port - 1]),
                int(reading.damaged[other, other_port - 1]) if other >= 0 else None,
            )
        )
    return states


def port_table(cell: int, layout: Layout, reading: NetworkReading) -> str:
    """`port_states` as HTML; a row's attributes `data-port`, `data-link`, `data-role` and `data-damaged` hold it."""
    rows = "".join(_row(state) for state in port_states(cell, layout, reading))
    heads = "".join(
        f'<td style="{_CELL};text-align:{side}" {more}>{name}</td>'
        for name, side, more in (
            ("port", "left", ""),
            ("neighbour", "left", ""),
            ("wire", "left", ""),
            ("damaged", "right", 'colspan="2"'),
        )
    )
    hint = "Frames with a wrong checksum, as they have arrived here and at the other end."
    return (
        '<table style="width:100%;margin-top:6px;line-height:1.5;border-spacing:0;font-variant-numeric:tabular-nums" '
        f'data-ports-of="{cell}" title="{hint}"><tr style="opacity:.65">{heads}</tr>{rows}</table>'
    )


_CELL = "padding:0 5px 0 0;vertical-align:top"


def _row(state: PortState) -> str:
    if not state.neighbour:
        free = f'<td style="{_CELL}">{state.port}</td><td style="{_CELL}" colspan="4">free</td>'
        return f'<tr style="opacity:.5" data-port="{state.port}">{free}</tr>'
    link = "down" if state.trouble else "up"
    colour = "#ff6b5e" if state.trouble else "#34c38f"
    told = f"down, {state.trouble}" if state.trouble else ROLE_WORDS[state.role]
    wire = _CELL if state.trouble else f"{_CELL};white-space:nowrap"
    there = "" if state.damaged_there is None else f"other end {state.damaged_there:,}"
    number = f"{_CELL};text-align:right;white-space:nowrap"
    return (
        f'<tr data-port="{state.port}" data-link="{link}" data-role="{state.role}" data-damaged="{state.damaged}">'
        f'<td style="{_CELL}">{state.port}</td><td style="{_CELL};white-space:nowrap">{state.neighbour}</td>'
        f'<td style="{wire};color:{colour}">{told}</td>'
        f'<td style="{number}">{state.damaged:,}</td><td style="{number};opacity:.65">{there}</td></tr>'
    )
