# SPDX-License-Identifier: Apache-2.0
"""What the host gets from a full skin, 66 cells a cable at 250 Hz: losses and latency, balanced and not."""

from __future__ import annotations

import numpy as np

from robotskin import firmware
from robotskin.layout import network_shapes
from robotskin_lab.bench.network_balance import Balance
from robotskin_lab.bench.network_runs import RATE_HZ, RELEASE_S, Service, latency_quantile_ms, trial_of
from robotskin_lab.bench.network_set import COMPACT


def service_figures(balances: list[Balance], naive: list[Service]) -> dict[str, float | int]:
    """Losses and latency of the compact skins of three cables, once 66 cells are on each: over the samples of all.

    Losses of first-arrival trees are the share of 250 Hz that the host does not hear, by the same firmware in the same
    runs before balance begins: what is beyond a cable is lost, or thinned out evenly by the rate divisor.

    Args:
        balances: settled runs.
        naive: of skins of 66 cells a cable on trees of the first arrival.
    """
    full = [
        (one.run.ports, one.run.service)
        for one in balances
        if one.run.kind in COMPACT and max(one.run.loads) <= firmware.CELLS_PER_PORT and one.run.service
    ]
    figures: dict[str, float | int] = {}
    if full:
        figures["loss_66_per_port"] = sum(served.lost for _, served in full) / sum(served.sent for _, served in full)
        figures["loss_66_samples"] = sum(served.sent for _, served in full)
        figures["missing_66_per_port"] = max(served.missing for _, served in full)
    if naive:
        # Before balance, a cable with more cells than it carries has its samples thinned out by the rate divisor.
        figures["naive_loss_66_per_port"] = sum(served.missing for served in naive) / len(naive)
        figures["naive_loss_66_per_port_max"] = max(served.missing for served in naive)
        figures["naive_latency_mean_ms"] = sum(served.latency_mean_ms for served in naive) / len(naive)
    three = [served for ports, served in full if ports == 3]
    if three:
        sent = sum(served.sent for served in three)
        figures["latency_mean_ms"] = sum(served.latency_mean_ms * served.sent for served in three) / sent
        figures["latency_p99_ms"] = latency_quantile_ms(three, 0.99)
        figures["latency_p99_worst_skin_ms"] = max(served.latency_p99_ms for served in three)
    return figures


FEWEST_CELLS, MOST_CELLS = 40, 80
COLUMNS = 11
SERVED_S = 0.2


def cells_carried(seed: int) -> int:
    """The most cells of a sheet that one cable carries at 250 Hz, none of their samples lost or thinned out.

    Looked for from `FEWEST_CELLS` to `MOST_CELLS`; 0 where it does not carry the fewest.
    """
    least, most = FEWEST_CELLS, MOST_CELLS
    if not _carries(least, seed):
        return 0
    if _carries(most, seed):
        return most
    while least + 1 < most:
        cells = (least + most) // 2
        if _carries(cells, seed):
            least = cells
        else:
            most = cells
    return least


def _carries(cells: int, seed: int) -> bool:
    links, position = network_shapes.lattice(COLUMNS, cells, wrapped=False)
    sheet = network_shapes.assemble("sheet", cells, links, position)
    root = COLUMNS // 2
    network = sheet.with_cables([(root, int(np.flatnonzero(sheet.free_ports[root])[0]) + 1)])
    trial = trial_of(network, seed)
    trial.run_until(RELEASE_S)
    trial.measure_anew()
    trial.run_until(RELEASE_S + SERVED_S)
    served = Service.of(trial.report(), cells, SERVED_S)
    # A cell's samples may miss the beginning or the end of the time by one; what is thinned out is half of them.
    return served.lost == 0 and served.sent >= cells * (RATE_HZ * SERVED_S - 1)
