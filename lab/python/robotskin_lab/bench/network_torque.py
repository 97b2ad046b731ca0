# SPDX-License-Identifier: Apache-2.0
"""Torque sums inside the network: how late, how complete, and whether any cell ever counts twice.

Every cell adds one bit that no other cell of its limb has, so that a sum tells which are in it: a cell that counted
twice would carry into another bit and leave fewer bits than cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import numpy as np

from robotskin.simulator import InProcess, parse_faults
from robotskin_lab import firmware
from robotskin_lab.bench.network_faults import fault_text
from robotskin_lab.bench.network_runs import wiring_of
from robotskin_lab.bench.network_set import skins
from robotskin_lab.bench.network_speed import world_of

JOINTS = 6
BITS = 15
"""Of a joint's 16, the sign apart."""
LIMB_CELLS = JOINTS * BITS
EPOCH_NS = firmware.EPOCH_TICKS * firmware.TICK_US * 1000
TORQUE_TYPE = next(number for name, number, _ in firmware.FRAME_TYPES if name == "torque")
FAULTS = ("link", "cell", "reboot", "cable", "zombie", "flap")
FROM_S, FAULT_S, TO_S = 0.1, 0.4, 0.8
WHOLE = 0.001


@dataclass(frozen=True)
class TorqueRun:
    """late_ms: from an epoch's tick to its datagram, each vector; doubles: vectors with a cell twice, or handed over
    twice; short: share of the contributions of cells in reach that are in no vector; fault: its kind, or none; deepest:
    hops of the skin's farthest cell.
    """

    fault: str
    late_ms: tuple[float, ...]
    doubles: int
    epochs: int
    short: float
    deepest: int


def torque_run(seed: int, with_fault: bool) -> TorqueRun:
    """198 cells on three cables of one section unit, epochs of 4 ms, from 0.1 s on: through balance, and a fault."""
    # Every fourth skin of the set has two section units, each with a sum of its own.
    network = skins(("sheet", "sheared_sheet", "cylinder")[seed % 3], 3, (seed + seed // 3) % 100)
    mailbox = InProcess()
    world = world_of(network, seed, mailbox)
    for cell in range(len(network)):
        limb, bit = divmod(cell, LIMB_CELLS)
        torque = [0] * JOINTS
        torque[bit // BITS] = 1 << bit % BITS
        world.network.contribute(cell, limb, torque)
    kind = FAULTS[seed % len(FAULTS)] if with_fault else ""
    if kind:
        text = fault_text(kind, network, Random(f"torque {seed}"), 1e3 * FAULT_S)
        for fault in parse_faults(text, wiring_of(network), seed + 1):
            world.network.inject(fault)
    world.run(round(1e9 * FROM_S))
    mailbox.take()
    reach, late, doubles, counted = 0, [], 0, 0
    seen: set[tuple[int, int, int]] = set()
    while world.time_ns < 1e9 * TO_S:
        world.run(EPOCH_NS)
        reach += sum(depth >= 0 for depth in world.network.depths)
        for unit, time_ns, datagram in mailbox.take():
            for at in range(firmware.DATAGRAM_HEADER_BYTES, len(datagram), firmware.DATAGRAM_RECORD_BYTES):
                if datagram[at] >> 4 != TORQUE_TYPE:
                    continue
                content = datagram[at : at + firmware.CONTENT_BYTES]
                _, fields = firmware.unpack(content + firmware.crc16(content).to_bytes(2, "big"))
                # Low bits of the epoch's number say which of the last epochs it is.
                behind = (time_ns // EPOCH_NS - fields["epoch"]) % 64
                epoch = time_ns // EPOCH_NS - behind
                late.append(1e-6 * (time_ns - epoch * EPOCH_NS))
                bits = sum((fields[f"joint_{joint}"] & 0xFFFF).bit_count() for joint in range(1, JOINTS + 1))
                key = (unit, epoch, fields["limb"])
                doubles += bits != fields["cells"] or key in seen
                seen.add(key)
                counted += fields["cells"]
    epochs = round((TO_S - FROM_S) * 1e9 / EPOCH_NS)
    deepest = max(world.network.depths)
    return TorqueRun(kind, tuple(late), doubles, epochs, max(0.0, 1 - counted / reach), deepest)


def torque_figures(runs: list[TorqueRun]) -> dict[str, float | int]:
    """The figures of the issue, over all runs; completeness without a fault and with one.

    torque_missing_worst: of the skin without a fault that misses most, so many hops deep (torque_missing_worst_hops);
    torque_whole_hops: how deep a skin without a fault is at most that misses less than a thousandth.
    """
    late = np.concatenate([run.late_ms for run in runs])
    unstruck = [run for run in runs if not run.fault]
    calm = [run.short for run in unstruck]
    struck = [run.short for run in runs if run.fault]
    worst = max(unstruck, key=lambda run: run.short)
    return {
        "torque_runs": len(runs),
        "torque_sums": len(late),
        "torque_sum_p50_ms": float(np.median(late)),
        "torque_sum_max_ms": float(late.max()),
        "torque_double_counts": sum(run.doubles for run in runs),
        "torque_missing_share": float(np.mean(calm)),
        "torque_missing_share_faults": float(np.mean(struck)),
        "torque_missing_worst": worst.short,
        "torque_missing_worst_hops": worst.deepest,
        "torque_whole_hops": max((run.deepest for run in unstruck if run.short < WHOLE), default=0),
    }
