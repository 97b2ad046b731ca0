# SPDX-License-Identifier: Apache-2.0
"""Writes the tables of docs/protocol.md from the firmware's headers (through their bindings).

`python docs/protocol_tables.py` rewrites them, `--check` only compares. A table stands between the lines
`<!-- table: NAME -->` and `<!-- end -->`.
"""

import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

from robotskin import firmware
from robotskin_lab import page_table

PAGE = Path(__file__).with_name("protocol.md")


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> list[str]:
    """The lines of a Markdown table."""
    lines = [list(map(str, head)), *(list(map(str, row)) for row in rows)]
    lines.insert(1, ["---"] * len(lines[0]))
    return ["| " + " | ".join(line) + " |" for line in lines]


def frame(name: str) -> list[str]:
    """The fields of one frame, by bits."""
    rows = []
    at = 0
    for field, signed, bits, meaning in firmware.FRAMES[name]:
        last = at + bits - 1
        span = f"{at}" if bits == 1 else f"{at} to {last}"
        rows.append((span, bits, f"`{field}`", "signed" if signed else "", meaning))
        at += bits
    rows.append((f"{at} to {at + 15}", 16, "checksum", "", "CRC-16 of all before it"))
    return table(("bits", "width", "field", "", "meaning"), rows)


def channels() -> list[str]:
    """The channels of a cell."""
    rows = []
    thresholds = dict(firmware.EVENT_THRESHOLDS)
    for name, signed, bits, step, unit in firmware.CHANNELS:
        rows.append((f"`{name}`", bits, "signed" if signed else "", f"{step:.6g} {unit}", thresholds[name]))
    return table(("channel", "bits", "", "one count is", "threshold (counts)"), rows)


def numbered(entries: Iterable[tuple[object, ...]], *head: str) -> list[str]:
    """Entries of (name, number, ...) by number."""
    return table(head, ((number, f"`{name}`", *rest) for name, number, *rest in entries))


def rates() -> list[str]:
    """The rates of clock mode."""
    return table(("commanded (Hz)", "period (us)"), firmware.CLOCK_RATES)


def timing() -> list[str]:
    """The periods and limits."""
    names = (
        ("FRAME_US", "one frame on a link"),
        ("TICK_US", "between two ticks of a root"),
        ("LINK_DOWN_US", "without a valid frame: the link is down"),
        ("QUARANTINE_US", "after boot, before a cell takes a parent"),
        ("STALE_US", "without a new sequence: a fresher neighbour may become parent"),
        ("STALE_LIMIT_US", "without a new sequence: the parent is given up"),
        ("ORPHAN_RESET_US", "without parent and child: the feasible distance is forgotten"),
        ("STATUS_US", "between two status frames, at most"),
        ("TOPOLOGY_US", "between two topology frames, at most"),
        ("TAG_FORGIVEN_US", "until one wrong tag of a port is forgiven"),
        ("JOIN_US", "between two requests for an id"),
        ("REFRESH_US", "silence a cell allows itself, plus a jitter of"),
        ("REFRESH_JITTER_US", "(that jitter)"),
        ("FRESH_US", "promised age of a value at the host"),
    )
    return table(("time (us)", "what"), ((getattr(firmware, name), text) for name, text in names))


TABLES: dict[str, Callable[[], list[str]]] = {
    "channels": channels,
    "frame types": lambda: numbered(firmware.FRAME_TYPES, "type", "frame", "from, to, what for"),
    "key steps": lambda: numbered(firmware.KEY_STEPS, "step", "name", "what"),
    "operations": lambda: numbered(firmware.OPERATIONS, "number", "operation", "index", "value"),
    "reply statuses": lambda: numbered(firmware.REPLY_STATUSES, "status", "name", "meaning"),
    "datagram kinds": lambda: numbered(firmware.DATAGRAM_KINDS, "kind", "name", "meaning"),
    "clock rates": rates,
    "timing": timing,
    **{f"frame {name}": lambda name=name: frame(name) for name in firmware.FRAMES},  # type: ignore[misc]
}


def with_tables(page: str) -> str:
    """The page with every table as the headers have it now. Raises KeyError for a table that is not made."""
    for name in re.findall(r"<!-- table: (.+?) -->", page):
        page = page_table.with_table(page, f"table: {name}", TABLES[name]())
    return page


def main() -> int:
    """Rewrite or compare the page; the exit status."""
    page = PAGE.read_text()
    fresh = with_tables(page)
    if "--check" in sys.argv:
        if page != fresh:
            print(f"{PAGE.name} differs from the headers; run python docs/protocol_tables.py", file=sys.stderr)
        return int(page != fresh)
    PAGE.write_text(fresh)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
