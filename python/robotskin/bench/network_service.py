"""What the host gets from a full skin, 66 cells a cable at 250 Hz: losses and latency, balanced and not."""

from __future__ import annotations

from robotskin._core import firmware
from robotskin.bench.network_balance import Balance
from robotskin.bench.network_set import COMPACT


def service_figures(balances: list[Balance]) -> dict[str, float | int]:
    """Losses of the compact skins with 66 cells on every cable; latency of those of 198 cells on three."""
    full = [
        one
        for one in balances
        if one.run.kind in COMPACT and max(one.run.loads) <= firmware.CELLS_PER_PORT and one.run.sent
    ]
    if not full:
        return {}
    figures: dict[str, float | int] = {
        "loss_66_per_port": sum(one.run.lost for one in full) / sum(one.run.sent for one in full),
        "loss_66_samples": sum(one.run.sent for one in full),
    }
    three = [one for one in full if one.run.ports == 3]
    if three:
        sent = sum(one.run.sent for one in three)
        figures["latency_mean_ms"] = sum(one.run.latency_mean_ms * one.run.sent for one in three) / sent
        figures["latency_p99_ms"] = max(one.run.latency_p99_ms for one in three)
    return figures
