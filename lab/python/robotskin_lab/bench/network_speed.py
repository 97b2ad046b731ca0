# SPDX-License-Identifier: Apache-2.0
"""How fast the world runs: the full protocol beside real time, the plain network beside SimPy, and at scale."""

from __future__ import annotations

import time

from robotskin import firmware
from robotskin.keys import SkinKeys
from robotskin.layout.cell_network import CellNetwork
from robotskin.layout.network_limits import least_depths
from robotskin.simulator import InProcess, LineQuality, NetworkOptions, World
from robotskin.world.ideal import default_processor
from robotskin_lab.bench.network_peers import run_plain, run_simpy, shortest_path_parents
from robotskin_lab.bench.network_set import limbs, sheet_10k, skins

PLAIN_CELLS_KIND = ("sheet", 3, 0)
"""The skin of the plain store-and-forward network: 198 cells, three cables."""

FORMATION_STEP_S = 1e-4


def world_of(network: CellNetwork, seed: int, mailbox: InProcess | None = None, step_s: float = 0.001) -> World:
    """A network without body or measurements, at 250 Hz; its datagrams lie in a mailbox until they are taken.

    It runs in whole steps of `step_s`, and what section units tell each other arrives between two of them.
    """
    chosen = NetworkOptions()
    chosen.seed = seed + 1
    chosen.processor = default_processor()
    chosen.unasked = True
    chosen.set_cell_key(SkinKeys.of_seed(seed).cell_key)
    chosen.line = LineQuality()
    letters = InProcess() if mailbox is None else mailbox
    return World(None, network.neighbours, network.id.tolist(), network.unit_descriptions(), chosen, letters, step_s)


def pace(network: CellNetwork, seed: int, warm_s: float, seconds: float) -> dict[str, float]:
    """Virtual time, hops and cell steps per second of processor time, after a warm-up."""
    world = world_of(network, seed)
    world.run(round(1e9 * warm_s))
    before = world.network.counts
    start = time.process_time()
    world.run(round(1e9 * seconds))
    spent = time.process_time() - start
    after = world.network.counts
    return {
        "realtime_factor": seconds / spent,
        "hops_per_s": (after.frames_delivered - before.frames_delivered) / spent,
        "cell_steps_per_s": (after.cell_steps - before.cell_steps) / spent,
        "cell_steps_per_virtual_s": (after.cell_steps - before.cell_steps) / seconds,
    }


def speed_figures(seed: int, quick: bool = False) -> dict[str, float | int]:
    """The figures of speed and size of state."""
    figures: dict[str, float | int] = {"cell_state_bytes": int(firmware.CELL_STATE_BYTES)}
    parents = shortest_path_parents(skins(*PLAIN_CELLS_KIND))
    figures["hops_per_s"] = run_plain(parents, 1.0 if quick else 10.0).hops_per_s
    figures["peer_simpy_hops_per_s"] = run_simpy(parents, 0.1 if quick else 0.5).hops_per_s
    figures["hops_ratio_to_simpy"] = figures["hops_per_s"] / figures["peer_simpy_hops_per_s"]
    full = pace(skins("robot_1260", 3, 0), seed, 0.1, 0.1 if quick else 0.5)
    figures["realtime_factor_1260"] = full["realtime_factor"]
    figures["full_protocol_hops_per_s"] = full["hops_per_s"]
    figures["full_protocol_cell_steps_per_s"] = full["cell_steps_per_s"]
    figures["full_protocol_cell_steps_per_virtual_s"] = full["cell_steps_per_virtual_s"]
    return figures


def formation_ms(network: CellNetwork, seed: int, longest_s: float) -> float:
    """Virtual time until every cell was on a shortest path, to a tenth of a millisecond; -1: not so soon."""
    world = world_of(network, seed, step_s=FORMATION_STEP_S)
    least = least_depths(network).tolist()
    while world.time_ns < 1e9 * longest_s:
        world.run(round(1e9 * FORMATION_STEP_S))
        if all(world.network.cell_hops(cell) == hops for cell, hops in enumerate(least)):
            return 1e-6 * world.time_ns
    return -1.0


def scale_figures(seed: int, quick: bool = False) -> dict[str, float | int]:
    """One sheet of 10 000 cells, 40 limbs of 250, and 100 000 cells."""
    figures: dict[str, float | int] = {
        "formation_10k_ms": formation_ms(sheet_10k(seed), seed, 0.06),
        "formation_limbs_ms": formation_ms(limbs(40, seed=seed), seed, 0.06),
    }
    ten = pace(limbs(40, seed=seed), seed, 0.02, 0.02 if quick else 0.1)
    figures["limbs_cells"] = 10_000
    figures["limbs_realtime_factor"] = ten["realtime_factor"]
    figures["limbs_hops_per_s"] = ten["hops_per_s"]
    if not quick:
        most = pace(limbs(400, seed=seed), seed, 0.012, 0.008)
        figures["throughput_100k_realtime_factor"] = most["realtime_factor"]
        figures["throughput_100k_hops_per_s"] = most["hops_per_s"]
        figures["throughput_100k_cell_steps_per_s"] = most["cell_steps_per_s"]
    return figures
