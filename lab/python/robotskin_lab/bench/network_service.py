# SPDX-License-Identifier: Apache-2.0
"""What the host gets from a full skin, 66 cells a cable at 250 Hz: losses and latency, balanced and not."""

from __future__ import annotations

from robotskin import firmware
from robotskin_lab.bench.network_balance import Balance
from robotskin_lab.bench.network_runs import Service, latency_quantile_ms
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
