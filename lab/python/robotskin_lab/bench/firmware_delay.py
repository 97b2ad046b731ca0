# SPDX-License-Identifier: Apache-2.0
"""How long touch takes to become joint torques, three ways, from ten to ten thousand cells.

Naive host: every sample goes up, and the host computes a Jacobian a cell. Aggregated host: every sample goes up, and
the host computes one product a link. Distributed: every cell computes its own torque, the network adds. Cells come as
limbs of up to 250 on section units of their own, as on a robot; one deep strip stands apart. Transport is simulated
time on the shipping firmware, computation of the host is measured here, that of the cell is cycles at 48 MHz.

Two delays are told of sums: a limb's own, from the beginning of the epoch to the arrival of its last vector, and that
of the last limb of all. The one depends on the limb, its depth above all; the other is the greatest of so many draws,
and grows a little with their number wherever they are not all alike.

A delay begins with the sample. In the distributed way it waits for the next epoch first, half of one on average; in the
others it waits in its section unit until the datagram is full or a millisecond old. Both are transport.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robotskin import robots
from robotskin.simulator import InProcess, LineQuality, NetworkOptions, UnitDescription, World
from robotskin.skin import Health, SkinModel, SkinState
from robotskin.tasks import SkinGains
from robotskin_lab import firmware
from robotskin_lab._lab.baselines import time_skin_task
from robotskin_lab.bench.progress import tell
from robotskin_lab.chip.rig import MS, sheet

CELLS = (10, 30, 100, 250, 1000, 2500, 10000)
LIMB_CELLS, PORTS = 250, 4
LIMBS = 40
"""Limbs seen of each size: those of the largest skin."""
EPOCH_NS = firmware.EPOCH_TICKS * firmware.TICK_US * 1000
WAIT_US = EPOCH_NS / 2000
ROBOT = "ur5"
FORM_MS, MEASURE_MS = 300, 60
TORQUE, CLOCK = (next(n for name, n, _ in firmware.FRAME_TYPES if name == kind) for kind in ("torque", "clock"))


@dataclass(frozen=True)
class Delay:
    """Of one size of skin, microseconds, medians: to the host, and there or in the cell."""

    cells: int
    samples_us: float
    """From a sample to its arrival at the host in its datagram."""
    sums_us: float
    """From the beginning of an epoch to the arrival of the last limb's vector at the host."""
    sums_max_us: float
    limb_us: float
    """From the beginning of an epoch to the arrival of a limb's own last vector, over epochs and limbs."""
    naive_us: float
    aggregated_us: float


def limb(cells: int) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Wiring of a limb of so many cells, some twelve around, with four cables (fewer where it is small) at one end."""
    columns = max(2, min(12, round(cells**0.5)))
    rows = -(-cells // columns)
    neighbours = sheet(columns, rows)[:cells].copy()
    neighbours[neighbours[:, :, 0] >= cells] = -1
    count = min(PORTS, max(1, cells // 60))
    roots = [(round((k + 0.5) * columns / count - 0.5), 4) for k in range(count)]
    return neighbours, roots


@dataclass(frozen=True)
class Transport:
    """Of one skin, microseconds."""

    samples_us: float
    sums_us: float
    """Median over the epochs of the last vector."""
    sums_max_us: float
    limb_us: float
    """Median over the epochs and limbs of a limb's last vector."""
    depth: int
    """Hops of the deepest cell."""


def network_delay(cells: int, seed: int, deep: bool = False) -> Transport:
    """Let a skin form, and watch what comes of it; skins of few limbs several times, so that as many limbs are seen."""
    samples: list[float] = []
    last: list[dict[int, float]] = []
    depth = 0
    for draw in range(max(1, LIMBS * LIMB_CELLS // max(cells, LIMB_CELLS)) if not deep else 1):
        world, mailbox = _skin(cells, 1000 * draw + seed, deep)
        arrivals: Arrivals = {}
        for _ in range(MEASURE_MS // 4):
            world.run(EPOCH_NS)
            for unit, time_ns, datagram in mailbox.take():
                _take(unit, time_ns, datagram, samples, arrivals)
        last += [arrivals[number] for number in sorted(arrivals)[1:-1]]
        depth = max(depth, *world.network.depths)
    epochs = np.array([max(limbs.values()) for limbs in last])
    own = [delay for limbs in last for delay in limbs.values()]
    return Transport(
        float(np.median(samples)), float(np.median(epochs)), float(epochs.max()), float(np.median(own)), depth
    )


def _skin(cells: int, seed: int, deep: bool) -> tuple[World, InProcess]:
    """A skin that has formed, every cell of which contributes."""
    wires: list[np.ndarray] = []
    units: list[UnitDescription] = []
    left = cells
    while left > 0:
        size = left if deep else min(LIMB_CELLS, left)
        neighbours, roots = limb(size) if not deep else (sheet(size // 5, 5), [(k * (size // 5), 3) for k in range(4)])
        base = int(sum(len(part) for part in wires))
        shifted = neighbours.copy()
        shifted[shifted[:, :, 0] >= 0, 0] += base
        wires.append(shifted)
        units.append(UnitDescription(len(units), 0, [(cell + base, port) for cell, port in roots]))
        left -= size
    options = NetworkOptions()
    options.seed, options.unasked, options.batch_us = seed, True, 1000
    options.line = LineQuality()
    mailbox = InProcess()
    world = World(None, np.concatenate(wires), [0] * cells, units, options, mailbox, 0.001)
    for cell in range(cells):
        world.network.contribute(cell, 0, [1] * 6)
    world.run(FORM_MS * MS)
    mailbox.take()
    return world, mailbox


Arrivals = dict[int, dict[int, float]]
"""Microseconds from the beginning of an epoch to the last vector of each section unit, by epoch and unit."""


def _take(unit: int, time_ns: int, datagram: bytes, samples: list[float], last: Arrivals) -> None:
    for at in range(firmware.DATAGRAM_HEADER_BYTES, len(datagram), firmware.DATAGRAM_RECORD_BYTES):
        kind = datagram[at] >> 4
        if kind not in (TORQUE, CLOCK):
            continue
        content = datagram[at : at + firmware.CONTENT_BYTES]
        _, fields = firmware.unpack(content + firmware.crc16(content).to_bytes(2, "big"))
        if kind == CLOCK:
            sampled_ns = fields["sample_tick"] * MS + fields["sample_phase"] * MS // 64
            samples.append(((time_ns - sampled_ns) % (16 * MS)) / 1e3)
        else:
            epoch = time_ns // EPOCH_NS - (time_ns // EPOCH_NS - fields["epoch"]) % 64
            limbs = last.setdefault(epoch, {})
            limbs[unit] = max(limbs.get(unit, 0.0), (time_ns - epoch * EPOCH_NS) / 1e3)


def host_us(cells: int, seed: int) -> tuple[float, float]:
    """Median time of the naive and of the aggregated skin task on this machine, every cell touched."""
    robot = robots.load(ROBOT).core
    generator = np.random.default_rng(seed)
    links = [name for name in robot.link_names if robot.link_joints[robot.link_index(name)] >= 0]
    pose = np.tile(np.eye(4), (cells, 1, 1))
    pose[:, :3, 3] = generator.uniform(-0.1, 0.1, (cells, 3))
    on = np.sort(generator.integers(0, len(links), cells)).astype(np.int32)
    ids = np.arange(cells)
    keys = ((ids // 16000) << 16 | (ids % 16000 + 1)).astype(np.uint32)
    no_neighbour = np.full((cells, 4, 2), -1, dtype=np.int32)
    no_neighbour[:, :, 1] = 0
    skin = SkinModel(links, keys, on, pose, no_neighbour, np.zeros(cells, dtype=np.int32))
    gains = SkinGains.uniform(cells, 3.0, 20.0, 0.35, 0.9, 0.02, 0.05)
    first, second = (_touched(cells, generator) for _ in range(2))
    rounds = max(100, min(2000, 2_000_000 // cells))
    posture = generator.uniform(-1, 1, robot.joint_count)
    times = time_skin_task(robot, skin, gains, first, second, posture, rounds)
    kinematics = float(np.median(times["kinematics"]))
    return (float(np.median(times["naive"])) + kinematics) / 1e3, (float(np.median(times["task"])) + kinematics) / 1e3


def _touched(cells: int, generator: np.random.Generator) -> SkinState:
    state = SkinState(cells)
    state.health[:] = Health.alive.value
    state.normal_force[:] = generator.uniform(0, 5, (cells, 3))
    return state


def delays(seed: int, sizes: tuple[int, ...] = CELLS) -> list[Delay]:
    """One size of skin after the other."""
    result = []
    for cells in sizes:
        tell(f"delays of {cells} cells")
        found = network_delay(cells, seed)
        result.append(
            Delay(cells, found.samples_us, found.sums_us, found.sums_max_us, found.limb_us, *host_us(cells, seed))
        )
    return result


def hop_us(seed: int) -> float:
    """Microseconds a hop adds to a sum on an idle path: chains of cells that do not sample, of 6 and of 30 hops."""

    def epoch_us(cells: int) -> float:
        options = NetworkOptions()
        options.seed, options.unasked, options.clock_rate_hz = seed, True, 0
        options.line = LineQuality()
        mailbox = InProcess()
        world = World(None, sheet(cells, 1), [0] * cells, [UnitDescription(0, 0, [(0, 3)])], options, mailbox, 0.001)
        for cell in range(cells):
            world.network.contribute(cell, 0, [1] * 6)
        world.run(FORM_MS * MS)
        mailbox.take()
        last: Arrivals = {}
        for _ in range(50):
            world.run(EPOCH_NS)
            for unit, time_ns, datagram in mailbox.take():
                _take(unit, time_ns, datagram, [], last)
        return float(np.median([last[number][0] for number in sorted(last)[1:-1]]))

    return (epoch_us(30) - epoch_us(6)) / 24


def delay_figures(
    seed: int, cell_us: float, sizes: tuple[int, ...] = CELLS, picture: Path | None = None
) -> dict[str, Any]:
    """All of it; `cell_us`: of a cell's own computation."""
    found = delays(seed, sizes)
    hop = hop_us(seed)
    deep = network_delay(LIMB_CELLS, seed, deep=True)
    deep_host = next(one for one in found if one.cells >= LIMB_CELLS).aggregated_us
    figures: dict[str, Any] = {"hop_us": hop, "cell_computation_us": cell_us}
    for one in found:
        figures |= {
            f"delay_naive_us_{one.cells}": one.samples_us + one.naive_us,
            f"delay_aggregated_us_{one.cells}": one.samples_us + one.aggregated_us,
            f"delay_distributed_us_{one.cells}": WAIT_US + one.sums_us + cell_us,
            f"transport_samples_us_{one.cells}": one.samples_us,
            f"transport_sums_us_{one.cells}": one.sums_us,
            f"sums_us_max_{one.cells}": one.sums_max_us,
            f"transport_limb_us_{one.cells}": one.limb_us,
            f"computation_naive_us_{one.cells}": one.naive_us,
            f"computation_aggregated_us_{one.cells}": one.aggregated_us,
        }
    whole = [one for one in found if one.cells >= LIMB_CELLS]
    first, last = whole[0], whole[-1]
    figures |= {
        "distributed_growth_with_cells": (last.limb_us - first.limb_us) / (first.limb_us + cell_us),
        "distributed_growth_of_last_limb": (last.sums_us - first.sums_us) / (first.sums_us + cell_us),
        "epoch_wait_us": WAIT_US,
        "deep_strip_hops": deep.depth,
        "deep_strip_aggregated_us": deep.samples_us + deep_host,
        "deep_strip_distributed_us": WAIT_US + deep.sums_us + cell_us,
    }
    for name, host in (("naive", [o.naive_us for o in found]), ("aggregated", [o.aggregated_us for o in found])):
        wins = [
            one.cells
            for one, compute in zip(found, host, strict=True)
            if WAIT_US + one.sums_us + cell_us < one.samples_us + compute
        ]
        figures[f"distributed_sooner_than_{name}_from_cells"] = min(wins) if wins else -1
    if picture is not None:
        draw(found, cell_us, picture)
    return figures


def draw(found: list[Delay], cell_us: float, path: Path) -> None:
    """The three curves, whole and split into transport and computation, in one picture."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4), layout="constrained")
    whole, parts = figure.subplots(1, 2)
    cells = [one.cells for one in found]
    ways = (
        ("naive host", "#d62839", [o.samples_us for o in found], [o.naive_us for o in found]),
        ("aggregated host", "#8f6bb8", [o.samples_us for o in found], [o.aggregated_us for o in found]),
        ("distributed", "#3d6ea5", [WAIT_US + o.sums_us for o in found], [cell_us] * len(found)),
    )
    for name, colour, transport, computation in ways:
        whole.plot(cells, np.add(transport, computation), color=colour, marker="o", markersize=3, label=name)
        parts.plot(cells, transport, color=colour, label=f"{name}: transport")
        parts.plot(cells, computation, color=colour, linestyle="--", label=f"{name}: computation")
    for axes, title in ((whole, "from touch to joint torques at the host"), (parts, "transport and computation")):
        axes.set(xscale="log", yscale="log", xlabel="cells, in limbs of up to 250", ylabel="us, median", title=title)
        axes.legend(fontsize=7, frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)
