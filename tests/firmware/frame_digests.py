# SPDX-License-Identifier: Apache-2.0
"""Digests of every frame and datagram of fixed runs: equal to the byte before and after a step that only moves code.

`python tests/firmware/frame_digests.py` compares the runs with the digests kept beside this file, and tells which
differ. After a change that is meant to be seen in the frames, `--write` keeps the new ones; the change of
`frame_digests.json` then stands in the same commit, and its message says what was meant.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from large_world import MS, sheet

from robotskin import firmware, robots
from robotskin.driver import Driver
from robotskin.robots.chains import Chain
from robotskin.simulator import ExternalCell, Fault, InProcess, LineQuality, NetworkOptions, UnitDescription, World
from robotskin_lab.campaign import draw_case, parse_case, run_case
from robotskin_lab.chip import build
from robotskin_lab.chip.rig import ChipRig, told_cell

KEPT = Path(__file__).with_suffix(".json")
KEPT_SEEDS = Path(__file__).parents[1] / "lab" / "campaign" / "kept_seeds.toml"
DRAWN_SEEDS = range(1, 41)
SKIN_SEEDS = range(1, 5)
CHIP_SEEDS = range(1, 4)
FAULTS = (
    "cut:cell=14,port=1,for=30ms@90ms",
    "reboot:cell=33,off=900us@130ms",
    "noise:cell=20,port=2,rate=0.002,for=40ms@160ms",
)
ORDERS = (("offset", 40, 1), ("mode", 1, 0), ("store", 0, 0), ("clock_rate", 125, 0), ("ping", 0, 0), ("mode", 0, 0))


def drawn_cases() -> dict[str, str]:
    """The campaign's first seeds: what was drawn, and what its frames were."""
    return {f"seed {seed}": _of_case(draw_case(seed)) for seed in DRAWN_SEEDS}


def kept_cases() -> dict[str, str]:
    """Some of the cases that once broke an invariant."""
    kept = tomllib.loads(KEPT_SEEDS.read_text())["kept"]
    return {f"kept {one['name']}": _of_case(parse_case(one["case"])) for one in kept[::4]}


def _of_case(case: Any) -> str:
    drawn = hashlib.blake2s(case.text.encode(), digest_size=4).hexdigest()
    return f"case {drawn} frames {run_case(case).log_hash:016x}"


def skins() -> dict[str, str]:
    """Sheets of 80 cells on two section units under faults, with orders and joint positions from the host."""
    return {f"skin {seed}": of_skin(seed) for seed in SKIN_SEEDS}


def of_skin(seed: int, orders: tuple[tuple[str, int, int], ...] = ORDERS) -> str:
    """The digest of one of them."""
    options = NetworkOptions()
    options.seed, options.unasked, options.line = seed, True, LineQuality()
    if seed % 2 == 0:
        options.set_cell_key(bytes(range(firmware.CELL_KEY_BYTES)))
    if seed > 2:
        options.line.lost_share, options.line.bit_error_rate = 2e-3, 1e-5
    mailbox = InProcess()
    units = [UnitDescription(0, 0, [(2, 4), (39, 1)]), UnitDescription(0, 1, [(71, 2)])]
    world = World(None, sheet(10, 8), [0] * 80, units, options, mailbox, 0.001)
    told = _told()
    for cell in range(80):
        world.network.set_torque_image(cell, told.image)
    for fault in FAULTS:
        world.network.inject(Fault(fault))
    driver = Driver([], spare_cells=80, spare_groups=1, session_seed=seed)
    total = hashlib.blake2s()
    for millisecond in range(400):
        world.run(MS)
        for unit, when_ns, datagram in mailbox.take():
            total.update(b"%d %d " % (unit, when_ns) + datagram)
            driver.handle(datagram, when_ns)
        driver.publish(world.time_ns)
        driver.set_joints(2, [100 * joint + millisecond for joint in range(6)], now_ns=world.time_ns)
        if millisecond % 50 == 49 and millisecond // 50 < len(orders):
            driver.command(*orders[millisecond // 50])
        for unit, _, datagram in driver.downlink(world.time_ns):
            mailbox.post(unit, datagram)
    return f"frames {world.network.log_hash:016x} datagrams {total.hexdigest()[:16]}"


def _told() -> firmware.TorqueParameters:
    chain = Chain.to(robots.load("ur5"), "wrist_3_link")
    pose = np.eye(4)
    pose[:3, 3] = (0.03, 0.02, 0.06)
    return told_cell(chain.of_cell(pose))


def chips() -> dict[str, str]:
    """What an emulated cell answers, input by input: frames, alarms, light and flash."""
    image = build()
    return {f"chip {seed}": _of_chip(image, seed) for seed in CHIP_SEEDS}


def _of_chip(image: Any, seed: int) -> str:
    line = LineQuality()
    line.lost_share, line.bit_error_rate = 1e-3, 1e-5
    rig = ChipRig(image, 4, 2, [(0, 3)], seed, _told(), [200 * joint for joint in range(6)], seed, line=line)
    total = hashlib.blake2s()
    answer: Callable[..., Any] = rig.chip.__call__

    def note(kind: int, port: int, sent: int, fault: bool, content: object, now_us: int) -> Any:
        told = answer(kind, port, sent, fault, content, now_us)
        total.update(repr((kind, port, sent, fault, content, now_us, told)).encode())
        return told

    external = ExternalCell(note)
    rig.network.put(seed, external)
    rig.run_ms(120)
    rig.press(16)
    for operation, value, index in ORDERS:
        rig.run_ms(30)
        rig.driver.command(operation, value, index)
    rig.network.cut(seed, 1)
    rig.run_ms(30)
    rig.network.reboot(seed, 2_000_000)
    rig.run_ms(40)
    assert external.differences == 0, external.first_difference
    return f"answers {total.hexdigest()[:16]} frames {rig.network.log_hash:016x}"


RUNS = {"drawn_cases": drawn_cases, "kept_cases": kept_cases, "skins": skins, "chips": chips}


def kept_digests() -> dict[str, dict[str, str]]:
    """The digests beside this file, by the name of the run and by case."""
    return dict(json.loads(KEPT.read_text()))


def main() -> int:
    """Compare, or keep what is now; 0 if nothing differs."""
    now = {name: run() for name, run in RUNS.items()}
    if "--write" in sys.argv[1:]:
        KEPT.write_text(json.dumps(now, indent=1) + "\n")
        return 0
    kept = kept_digests()
    differing = [case for name in now for case in now[name] if kept[name].get(case) != now[name][case]]
    print(f"{sum(map(len, now.values()))} runs, {len(differing)} differ", *differing[:10], sep="\n  ")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
