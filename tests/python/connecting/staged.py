# SPDX-License-Identifier: Apache-2.0
"""A rehearsed UR5 and the units of one patch of its skin, for the tests of this folder."""

import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from robotskin import robots
from robotskin.connecting import SectionUnits
from robotskin.cycle import GuardLimits
from robotskin.keys import SkinKeys
from robotskin.layout import Layout
from robotskin.rehearsal import Process
from robotskin.robots.gains import GainSet

HOST = f"127.80.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
ROBOT = robots.load("ur5")
PATIENT_NS = 1_000_000_000


class PatientGains(GainSet):
    """For a machine that other tests hold up: the guard waits longer for joints, skin and cycle."""

    def guard_limits(self, robot) -> GuardLimits:
        limits = super().guard_limits(robot)
        limits.joints_timeout_ns = limits.largest_cycle_ns = PATIENT_NS
        return limits


@dataclass
class Stage:
    arm: Process
    units: Process
    layout: Layout
    layout_file: Path
    key: Path
    addresses: list


def held_units(stage: Stage, keys: SkinKeys | None = None, layout: Layout | None = None, addresses=None):
    return SectionUnits(layout or stage.layout, addresses or stage.addresses, keys or SkinKeys.load(stage.key))


def command(
    stage: Stage, *more: str, key: Path | None = None, unit: tuple[str, int] | None = None, touched: bool = False
) -> list[str]:
    host, port = unit or stage.addresses[0]
    return [
        str(Path(sys.executable).with_name("robotskin")), "connect", "ur5", "--robot-port", f"ur:{HOST}",
        "--units", f"{host}:{port}",
        "--key", str(key or stage.key), "--layout", str(stage.layout_file), "--headless", *more,
        *([] if touched else ["--skip-touch"]),
    ]  # fmt: skip


def soon(done: Callable[[], bool], within_s: float = 20.0) -> bool:
    ends = time.monotonic() + within_s
    while not done() and time.monotonic() < ends:
        time.sleep(0.02)
    return done()
