# SPDX-License-Identifier: Apache-2.0
"""The fixed set of skins on which the network is judged, made before any tuning; a test compares its digests.

A skin is named by kind, number of cables K (2 to 5) and seed (0 to 99):

- `sheet`, `sheared_sheet`: 66 K cells, aspect ratio drawn from 1 to 2. `cylinder`: 66 K cells, 9 to 13 around, 12 % of
  the links missing. These are the compact skins: K cables at cells drawn uniformly from the rim.
- `ring_12`: 66 K cells in 12 compact patches in a ring, two bridges from each to the next; K cables.
- `robot_1260`: 1260 cells in 47 patches, rings of six patches with two bridges; K cables a ring.
- `ur5`, `allegro_right_hand`, `talos`, `dual_arm`: the finished layouts; their patches are not joined, so each patch
  has K cables, or one for every eight of its cells where that is less, but one at least.

Cables sit at free ports of drawn cells, no two at one cell. Every fourth skin (seed 3, 7, ...) has its cables dealt to
two section units in turn; where there are more cables than ports, there are as many section units as it takes, all of
one group.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib import resources
from random import Random

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.layout.cell_network import CableEnd, CellNetwork
from robotskin.layout.errors import LayoutError
from robotskin.layout.finished_layouts import finished
from robotskin.layout.network_shapes import (
    assemble,
    draw,
    labels,
    lattice,
    rings_of_patches,
    shares,
    without_links,
)

COMPACT = ("sheet", "sheared_sheet", "cylinder")
BRIDGED = ("ring_12", "robot_1260")
ROBOTS = ("ur5", "allegro_right_hand", "talos", "dual_arm")
KINDS = (*COMPACT, *BRIDGED, *ROBOTS)
PORTS = (2, 3, 4, 5)
SEEDS = range(100)
MISSING_LINKS = 0.12


def skins(kind: str, ports: int = 3, seed: int = 0) -> CellNetwork:
    """One skin of the set, the same for ever.

    Args:
        kind: one of `KINDS`.
        ports: cables K.
        seed: draws shape and places of the cables.

    Raises:
        LayoutError: a kind that there is not.
    """
    random = Random(f"{kind} {ports} {seed}")
    units = 2 if seed % 4 == 3 else 1
    cells = firmware.CELLS_PER_PORT * ports
    if kind in ("sheet", "sheared_sheet"):
        sheared = kind == "sheared_sheet"
        while True:
            columns = round(float(np.sqrt(cells * (1 + random.random()))))
            links, position = lattice(columns, cells, sheared=sheared)
            if labels(cells, links).max() == 0:
                break
        network = assemble(kind, cells, links, position)
        rim = network.free_ports.any(axis=1)
    elif kind == "cylinder":
        links, position = lattice(9 + draw(random, 5), cells, wrapped=True)
        # The rim is that of the whole cylinder: no one plugs a cable where a link is missing by accident.
        rim = assemble(kind, cells, links, position).free_ports.any(axis=1)
        network = assemble(kind, cells, without_links(cells, links, MISSING_LINKS, random), position)
    elif kind == "ring_12":
        network = rings_of_patches(kind, shares(random, 12, cells, 4), 12, 2, random)
        rim = network.free_ports.any(axis=1)
    elif kind == "robot_1260":
        network = rings_of_patches(kind, shares(random, 47, 1260, 8), 6, 2, random)
        rim = network.free_ports.any(axis=1)
    elif kind in ROBOTS:
        network = robot(kind)
        rim = network.free_ports.any(axis=1)
    else:
        raise LayoutError(f"no skin of kind {kind!r}; there are {', '.join(KINDS)}")
    ends: list[tuple[int, int]] = []
    for part in range(int(network.part.max()) + 1):
        members = np.flatnonzero(rim & (network.part == part))
        size = int(np.sum(network.part == part))
        wanted = min(ports, max(1, size // 8)) if kind in ROBOTS else ports
        ends += [(cell, free_port(network, cell)) for cell in draw_cells(random, members, wanted)]
    units = max(units, -(-len(ends) // firmware.SECTION_UNIT_PORTS_MAX))
    return network.with_cables(ends, units)


def draw_cells(random: Random, cells: NDArray, count: int) -> list[int]:
    """`count` different ones, uniformly."""
    left = [int(cell) for cell in cells]
    return [left.pop(draw(random, len(left))) for _ in range(count)]


def free_port(network: CellNetwork, cell: int) -> int:
    """The first port without a neighbour."""
    return int(np.flatnonzero(network.free_ports[cell])[0]) + 1


@cache
def robot(name: str) -> CellNetwork:
    """The cells of a finished layout, in one section-unit group, without cables."""
    network = CellNetwork.of_layout(finished(name))
    ids = np.arange(1, len(network) + 1, dtype=np.uint16)
    return replace(network, cables=(), id=ids, group=np.ones(len(network), dtype=np.uint16))


def sheet_10k(seed: int = 0) -> CellNetwork:
    """10 000 cells on one square sheet with 160 cables at its rim."""
    links, position = lattice(100, 10_000)
    network = assemble("sheet_10k", 10_000, links, position)
    cells = draw_cells(Random(f"sheet_10k {seed}"), np.flatnonzero(network.free_ports.any(axis=1)), 160)
    return network.with_cables([(cell, free_port(network, cell)) for cell in cells], units=11)


def limbs(count: int, cells: int = 250, ports: int = 4, seed: int = 0) -> CellNetwork:
    """Cylinders of 13 around, one beside the other, each with a section-unit group and drawn cables of its own."""
    random = Random(f"limbs {count} {cells} {ports} {seed}")
    links, position = lattice(13, cells, wrapped=True)
    one = assemble("limb", cells, links, position)
    rim = np.flatnonzero(one.free_ports.any(axis=1))
    limb = np.repeat(np.arange(count, dtype=np.int32), cells)
    neighbours = np.tile(one.neighbours, (count, 1, 1))
    neighbours[:, :, 0] += np.where(neighbours[:, :, 0] >= 0, cells * limb[:, None], 0)
    cables = tuple(
        CableEnd(number + 1, 0, port, number * cells + cell, free_port(one, cell))
        for number in range(count)
        for port, cell in enumerate(draw_cells(random, rim, ports), start=1)
    )
    ids, group = np.tile(one.id, count), (limb + 1).astype(np.uint16)
    return CellNetwork("limbs", neighbours, cables, ids, group, limb, limb, np.tile(one.position_m, (count, 1)))


def digest(networks: Iterator[CellNetwork]) -> str:
    """SHA-256 over which cell is wired to which and where the cables are."""
    total = hashlib.sha256()
    for network in networks:
        total.update(network.neighbours.astype("<i4").tobytes())
        for cable in network.cables:
            total.update(repr((cable.group, cable.unit, cable.port, cable.cell, cable.cell_port)).encode())
    return total.hexdigest()


def digests(kind: str) -> dict[str, str]:
    """The digest of a kind for each K, over all seeds."""
    return {f"{kind} {ports}": digest(skins(kind, ports, seed) for seed in SEEDS) for ports in PORTS}


def committed_digests() -> dict[str, str]:
    """What `digests` gave when the set was fixed."""
    return json.loads(resources.files("robotskin_lab.bench").joinpath("network_set.json").read_text(encoding="utf-8"))
