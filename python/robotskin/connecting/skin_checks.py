# SPDX-License-Identifier: Apache-2.0
"""What is asked of a skin before its robot may move: the version of its firmware, and which cells are neighbours."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.connecting.errors import ConnectError
from robotskin.driver import Driver
from robotskin.layout import Layout

ASK_S = 1.0
"""Between two questions."""
LEAST_SHARE = 0.9
"""Of the cells that must answer, and of the wires told that the layout must have."""
TOLD_MOST = 3
"""Cells or wires of which an error tells."""

Rows = NDArray[np.int64]


def check_skin(driver: Driver, layout: Layout, alive: Rows, within_s: float = 5.0) -> None:
    """Ask section units and the living cells, rows of the layout, what they are, and compare it with what is expected.

    Raises ConnectError for firmware of another version than this host's, for cells that do not answer in time, and for
    wires that the layout does not have: it is the layout of another skin.
    """
    versions = _asked(driver, layout, alive, within_s)
    _check_versions(driver, versions)
    if len(versions) < LEAST_SHARE * len(alive):
        silent = sorted(set(alive.tolist()) - versions.keys())
        raise ConnectError(
            f"skin: found {len(versions)} of {len(alive)} cells that answer, expected {LEAST_SHARE:.0%} or more; they "
            f"send samples but take no commands: {silent[:TOLD_MOST]} …; are the keys of these cells those of the file?"
        )
    _check_wires(driver, layout)


def _asked(driver: Driver, layout: Layout, alive: Rows, within_s: float) -> dict[int, int]:
    """The version of each row that answers; once all have, or the time is over, neighbours have been told as well."""
    versions: dict[int, int] = {}
    ends, ask_s = time.monotonic() + within_s, 0.0
    while time.monotonic() < ends:
        if time.monotonic() >= ask_s:
            if ask_s > 0 and not versions:
                # A unit that was started anew does not know which counter its cells have come to.
                # SAFETY: what was recorded before passes no more than without, for its tag is of an earlier second.
                driver.leap_command_counter()
            ask_s = time.monotonic() + ASK_S
            for group in np.unique(layout.group[alive]).tolist():
                driver.command("ping", group=group)
                driver.command("topology", group=group)
        time.sleep(0.01)
        replies = [reply for reply in driver.replies() if reply["operation"] == "ping"]
        for row, reply in zip(layout.cells_of([reply["key"] for reply in replies]), replies, strict=True):
            if row >= 0:
                versions[int(row)] = int(reply["version"])
        told = driver.topology()
        heard = layout.cells_of(np.asarray(told["key"])[np.asarray(told["heard_ns"]) > 0])
        if set(alive.tolist()) <= versions.keys() & set(heard.tolist()):
            break
    return versions


def _check_versions(driver: Driver, versions: dict[int, int]) -> None:
    expected = firmware.FIRMWARE_VERSION
    for unit in driver.units():
        if unit["version"] != expected:
            raise ConnectError(
                f"section unit {unit['group']}.{unit['unit']}: found firmware of version {unit['version']}, expected "
                f"{expected}; give unit and host the same robotskin"
            )
    others = {row: version for row, version in versions.items() if version != expected}
    if others:
        found = ", ".join(f"cell {row}: {version}" for row, version in sorted(others.items())[:TOLD_MOST])
        raise ConnectError(
            f"skin: found firmware of another version in {len(others)} cells ({found}), expected {expected}; flash "
            "them with the firmware of this host's robotskin (robotskin chip build)"
        )


def _check_wires(driver: Driver, layout: Layout) -> None:
    told = driver.topology()
    keys, ids, ports = (np.asarray(told[name], np.int64) for name in ("key", "neighbour_id", "neighbour_port"))
    rows = layout.cells_of(keys)
    # Single wires may be plugged otherwise than planned: where a cell sits does not depend on them.
    wired = (ids != firmware.ID_NONE) & (ids != firmware.ID_SECTION_UNIT) & (rows >= 0)[:, None]
    wired &= (np.asarray(told["heard_ns"]) > 0)[:, None]
    at, port = np.nonzero(wired)
    others = layout.cells_of((keys[at] & ~0xFFFF) | ids[at, port])
    found = np.stack([others, ports[at, port]], axis=1)
    expected = layout.neighbours[rows[at], port]
    wrong = np.flatnonzero((found != expected).any(axis=1))
    if len(wrong) <= (1.0 - LEAST_SHARE) * len(at):
        return
    lines = [
        f"cell {rows[at[one]]}, port {port[one] + 1}: cell {found[one, 0]}, port {found[one, 1]} instead of "
        + (f"cell {expected[one, 0]}, port {expected[one, 1]}" if expected[one, 0] >= 0 else "none")
        for one in wrong[:TOLD_MOST]
    ]
    raise ConnectError(
        f"skin: found {len(wrong)} of {len(at)} wires that layout {layout.robot} of {len(layout)} cells does not have "
        f"({'; '.join(lines)}); give the layout of this skin with --layout"
    )
