# SPDX-License-Identifier: Apache-2.0
"""`robotskin bench unit`: 66 host-built cells on one serial line behind a section unit, in virtual and in real time."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

import numpy as np

from robotskin.driver import Driver, monotonic_ns
from robotskin.firmware import CELLS_PER_PORT
from robotskin.keys import SkinKeys
from robotskin.serial_lines import CellRunner, HostCell, SetSensors, UnitDaemon, VirtualSkin
from robotskin_lab.bench.progress import tell

GROUP_KEY = 1 << 16
EPOCH_NS = 1_800_000_000_000_000_000
FORM_S = 1.0
FRESH_NS = 100_000_000
LONGEST_HEAL_S = 10.0


def run(*, seed: int = 1, cells: int = CELLS_PER_PORT, seconds: float = 5.0, pulls: int = 5) -> dict[str, float]:
    """Samples lost between cells and host, and the time until a skin whose line was pulled is whole again.

    Args:
        seed: of the wiring, the keys and the pulls.
        cells: on the line.
        seconds: of counting, in virtual and in real time.
        pulls: of the line, in real time.
    """
    random = np.random.default_rng(seed)
    tell("virtual time")
    figures = _virtual(seed, random, cells, seconds)
    tell("real time")
    figures |= _real(seed, random, cells, seconds, pulls)
    figures["load_average"] = os.getloadavg()[0]
    return figures


def drawn_tree(cells: int, random: np.random.Generator) -> list[HostCell]:
    """A tree of cells, each at a free port of one that was drawn before; the first one's port 1 is at line 0."""
    ends = [[(-1, 0, -1)] * 4 for _ in range(cells)]
    ends[0][0] = (-1, 0, 0)
    free = [(0, 2), (0, 3), (0, 4)]
    for cell in range(1, cells):
        parent, port = free.pop(int(random.integers(len(free))))
        own = int(random.integers(1, 5))
        ends[parent][port - 1], ends[cell][own - 1] = (cell, own, -1), (parent, port, -1)
        free += [(cell, other) for other in range(1, 5) if other != own]
    return [HostCell(at + 1, ends[at], at + 1, int(random.integers(1, 1 << 30))) for at in range(cells)]


def _resting(cells: int) -> SetSensors:
    sensors, counts = SetSensors(cells), np.zeros((cells, 9), dtype=np.int32)
    counts[:, 6] = 256
    sensors.set(counts)
    return sensors


def _virtual(seed: int, random: np.random.Generator, cells: int, seconds: float) -> dict[str, float]:
    keys = SkinKeys.of_seed(seed)
    driver = Driver([GROUP_KEY | at + 1 for at in range(cells)], keys.datagram_key, session_seed=seed)

    def take(datagram: bytes, now_ns: int) -> None:
        driver.handle(datagram, now_ns - EPOCH_NS)

    skin = VirtualSkin(drawn_tree(cells, random), _resting(cells), 1, keys.datagram_key, keys.cell_key, EPOCH_NS, take)
    before: dict[str, int] = {}
    for ms in range(round((FORM_S + seconds) * 1000)):
        if ms == round(FORM_S * 1000):
            before = driver.statistics() | {"taken": skin.samples}
        now_ns = EPOCH_NS + (ms + 1) * 1_000_000
        skin.run_until(now_ns)
        driver.publish(now_ns - EPOCH_NS)
        for _, _, datagram in driver.downlink(now_ns - EPOCH_NS):
            skin.receive(datagram)
    after = driver.statistics() | {"taken": skin.samples}
    return {
        "virtual_samples": float(after["taken"] - before["taken"]),
        "virtual_samples_lost": float(after["frames_missing"] - before["frames_missing"]),
    }


def _real(seed: int, random: np.random.Generator, cells: int, seconds: float, pulls: int) -> dict[str, float]:
    keys = SkinKeys.of_seed(seed)
    with tempfile.TemporaryDirectory() as folder:
        line = str(Path(folder) / "port1")
        skin = CellRunner(drawn_tree(cells, random), keys.cell_key, _resting(cells), [(line, True)])
        unit = UnitDaemon([line], key=keys.datagram_key, cell_key=keys.cell_key, session=seed)
        names = [GROUP_KEY | at + 1 for at in range(cells)]
        driver = Driver(names, keys.datagram_key, ("127.0.0.1", 0), [unit.address], realtime=True)
        try:
            for one in (skin, unit, driver):
                one.start()
            formed_s = _until_fresh(driver)
            time.sleep(FORM_S)
            skin.forget_stalls()
            unit.forget_stalls()
            before, taken, processor = driver.statistics(), skin.report()["samples"], time.process_time()
            time.sleep(seconds)
            after, report, unit_report = driver.statistics(), skin.report(), unit.report()
            samples = report["samples"] - taken
            heard = sum(after[name] - before[name] for name in ("clock_frames", "event_frames"))
            figures = {
                "real_formed_s": formed_s,
                "real_samples": float(samples),
                "real_samples_lost_share": max(0.0, 1 - heard / samples),
                "real_links_lost": float(report["links_lost"]),
                "real_stalls": float(report["stalls"] + unit_report["stalls"]),
                "real_worst_stall_ms": 1e3 * max(report["worst_stall_s"], unit_report["worst_stall_s"]),
                "real_cpu_percent": 100 * (time.process_time() - processor) / seconds,
            }
            heals = []
            for _ in range(pulls):
                skin.pull(0, True)
                time.sleep(0.3 + float(random.uniform(0, 0.1)))
                skin.pull(0, False)
                heals.append(_until_fresh(driver))
            return figures | {"real_heal_worst_s": max(heals, default=0.0)}
        finally:
            driver.stop()
            unit.stop()
            skin.stop()


def _until_fresh(driver: Driver) -> float:
    """Seconds until every cell has been heard within a tenth of one."""
    began = time.monotonic()
    while time.monotonic() - began < LONGEST_HEAL_S:
        if (monotonic_ns() - driver.samples()["stamp_ns"] < FRESH_NS).all():
            break
        time.sleep(0.005)
    return time.monotonic() - began
