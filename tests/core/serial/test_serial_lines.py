# SPDX-License-Identifier: Apache-2.0
"""Section unit and host-built cells with serial lines between: in virtual time, and over pseudo-terminals."""

import os
import socket
import time
from pathlib import Path

import numpy as np
import pytest

from robotskin import firmware
from robotskin.connecting.section_units import datagram_version
from robotskin.driver import Driver, monotonic_ns
from robotskin.keys import SkinKeys
from robotskin.serial_lines import (
    CellRunner,
    HostCell,
    LibrarySensors,
    SerialError,
    SetSensors,
    UnitDaemon,
    VirtualSkin,
    check_latency_timer,
)

EPOCH_NS = 1_800_000_000_000_000_000
GROUP = 1 << 16


def tree(count: int, seed: int) -> list[HostCell]:
    """Three children a cell; the first one's port 1 is at line 0."""
    ends = [[(-1, 0, -1)] * 4 for _ in range(count)]
    ends[0][0] = (-1, 0, 0)
    for at in range(1, count):
        parent, port = (at - 1) // 3, 2 + (at - 1) % 3
        ends[parent][port - 1], ends[at][0] = (at, 1, -1), (parent, port, -1)
    return [HostCell(at + 1, ends[at], at + 1, seed + at) for at in range(count)]


def resting(count: int) -> tuple[SetSensors, np.ndarray]:
    sensors, counts = SetSensors(count), np.zeros((count, 9), dtype=np.int32)
    counts[:, 6] = 256
    counts[:, 0] = np.arange(count)
    sensors.set(counts)
    return sensors, counts


class Virtual:
    """A virtual skin and the host's driver."""

    def __init__(self, count: int, seed: int) -> None:
        keys = SkinKeys.of_seed(seed)
        self.sensors, self.counts = resting(count)
        self.driver = Driver([GROUP | at + 1 for at in range(count)], keys.datagram_key, session_seed=seed)
        self.now_ns = EPOCH_NS
        self.skin = VirtualSkin(
            tree(count, seed), self.sensors, 1, keys.datagram_key, keys.cell_key, EPOCH_NS, self.take
        )

    def take(self, datagram: bytes, now_ns: int) -> None:
        self.driver.handle(datagram, now_ns - EPOCH_NS)

    def run(self, seconds: float) -> dict[str, int]:
        before, taken = self.driver.statistics(), self.skin.samples
        for _ in range(round(seconds * 1000)):
            self.now_ns += 1_000_000
            self.skin.run_until(self.now_ns)
            self.driver.publish(self.now_ns - EPOCH_NS)
            for _, _, datagram in self.driver.downlink(self.now_ns - EPOCH_NS):
                self.skin.receive(datagram)
        after = self.driver.statistics()
        return {name: after[name] - before[name] for name in after} | {"taken": self.skin.samples - taken}


def test_66_cells_on_one_line_lose_nothing_in_virtual_time(seed: int) -> None:
    virtual = Virtual(66, seed)
    virtual.run(1.0)
    counted = virtual.run(2.0)
    assert counted["frames_missing"] == 0
    assert counted["taken"] == 66 * 500
    assert abs(counted["clock_frames"] - counted["taken"]) <= 66
    assert (virtual.driver.samples()["proximity"] == virtual.counts[:, 0]).all()


def test_a_line_that_is_pulled_loses_samples_and_heals_within_a_second(seed: int) -> None:
    virtual = Virtual(12, seed)
    virtual.run(1.0)
    virtual.skin.pull(0, True)
    assert virtual.run(0.5)["clock_frames"] <= 12
    virtual.skin.pull(0, False)
    virtual.run(1.0)
    counted = virtual.run(1.0)
    assert counted["frames_missing"] == 0
    assert counted["clock_frames"] >= 12 * 249


def test_the_only_line_of_a_skin_is_not_held_down_while_it_falls_now_and_then(seed: int) -> None:
    """As under a machine that stalls: 10 ms of silence, three times a second."""
    virtual = Virtual(12, seed)
    virtual.run(1.0)
    heard = taken = 0
    for _ in range(30):
        virtual.skin.pull(0, True)
        silent = virtual.run(0.01)
        virtual.skin.pull(0, False)
        counted = virtual.run(0.29)
        heard += silent["clock_frames"] + counted["clock_frames"]
        taken += silent["taken"] + counted["taken"]
    assert heard > 0.8 * taken


def wait_until(holds, within_s: float) -> bool:
    ends = time.monotonic() + within_s
    while time.monotonic() < ends:
        if holds():
            return True
        time.sleep(0.02)
    return False


def test_cells_on_a_pseudo_terminal_reach_the_host_and_come_back_when_it_is_pulled(seed: int, tmp_path: Path) -> None:
    """In real time: cells are found and heard; how many samples a busy machine loses is told elsewhere."""
    keys, line = SkinKeys.of_seed(seed), str(tmp_path / "port1")
    sensors, _ = resting(3)
    cells = CellRunner(tree(3, seed), keys.cell_key, sensors, [(line, True)])
    unit = UnitDaemon([line], key=keys.datagram_key, cell_key=keys.cell_key, session=seed + 1)
    driver = Driver([GROUP | at + 1 for at in range(3)], keys.datagram_key, ("127.0.0.1", 0), [unit.address])
    try:
        for one in (cells, unit, driver):
            one.start()

        def fresh() -> bool:
            return bool((monotonic_ns() - driver.samples()["stamp_ns"] < 500_000_000).all())

        assert wait_until(fresh, 20)
        assert unit.report()["named"] == 3
        cells.stop()
        del cells
        assert not os.path.lexists(line)
        assert wait_until(lambda: unit.report()["lines"][0]["pulled"] == 1, 5)
        time.sleep(0.6)
        assert not fresh()
        cells = CellRunner(tree(3, seed + 100), keys.cell_key, sensors, [(line, True)])
        cells.start()
        assert wait_until(fresh, 20)
        report = unit.report()
        assert {"stalls", "worst_stall_s", "realtime"} <= set(report)
        assert report["lines"][0]["frames_in"] > 20
    finally:
        driver.stop()
        unit.stop()


def test_a_unit_tells_its_version_to_those_of_another_and_to_none_else(tmp_path: Path, seed: int) -> None:
    keys, line = SkinKeys.of_seed(seed), str(tmp_path / "line")
    cells = CellRunner(tree(1, seed), keys.cell_key, resting(1)[0], [(line, True)])
    cells.start()
    unit = UnitDaemon([line], key=keys.datagram_key, cell_key=keys.cell_key, session=seed + 1)
    unit.start()
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            assert datagram_version(unit.address, 5.0) == firmware.DATAGRAM_VERSION
            other.settimeout(0.3)
            other.connect(unit.address)
            magic = firmware.DATAGRAM_MAGIC.to_bytes(4, "big")
            own = magic + bytes([firmware.DATAGRAM_VERSION])
            for silent in (b"", own, own.ljust(firmware.DATAGRAM_HEADER_BYTES, b"\0"), magic + b"\0", b"\0" * 36):
                other.send(silent)
                with pytest.raises(TimeoutError):
                    other.recv(64)
            assert unit.report()["other_versions"] == 1
    finally:
        unit.stop()
        cells.stop()


def test_cells_with_another_key_are_not_named_to_the_host(seed: int) -> None:
    virtual = Virtual(3, seed)
    virtual.run(0.5)
    assert virtual.run(0.5)["clock_frames"] > 0
    foreign = Virtual(3, seed)
    other = SkinKeys.of_seed(seed + 1)
    foreign.driver = Driver([GROUP | 1], other.datagram_key, session_seed=seed)
    counted = foreign.run(0.5)
    assert counted["accepted"] == 0


@pytest.mark.parametrize(("timer_ms", "refused"), [(1, False), (2, False), (3, True), (16, True)])
def test_an_adapter_that_holds_bytes_back_is_refused(timer_ms: int, refused: bool, tmp_path: Path) -> None:
    device = tmp_path / "sys/bus/usb-serial/devices/ttyUSB7"
    device.mkdir(parents=True)
    (device / "latency_timer").write_text(f"{timer_ms}\n")
    (tmp_path / "ttyUSB7").touch()
    if refused:
        with pytest.raises(SerialError, match=rf"found a latency timer of {timer_ms} ms, expected at most 2"):
            check_latency_timer(str(tmp_path / "ttyUSB7"), str(tmp_path / "sys"))
    else:
        check_latency_timer(str(tmp_path / "ttyUSB7"), str(tmp_path / "sys"))


def test_what_is_no_line_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for path, why in ((tmp_path / "nothing", "No such file"), (tmp_path / "file", "is no terminal")):
        with pytest.raises(SerialError, match=why):
            UnitDaemon([str(path)], key=None, cell_key=None, session=1)
    with pytest.raises(SerialError, match="there is no cell 7"):
        CellRunner([HostCell(1, [(7, 1, -1)] * 4)], None, SetSensors(1), [])
    with pytest.raises(SerialError):
        LibrarySensors(str(tmp_path / "file"))


def test_a_unit_and_a_host_that_are_started_anew_together_command_cells_that_know_later_commands(
    seed: int, tmp_path: Path
) -> None:
    keys = SkinKeys.of_seed(seed)
    sensors, _ = resting(3)
    line, names = str(tmp_path / "line"), [GROUP | at + 1 for at in range(3)]
    skin = CellRunner(tree(3, seed), keys.cell_key, sensors, [(line, True)])
    skin.start()

    def pinged(commands: int, leaps: int) -> int:
        """Of how many cells an answer comes to one of the last commands, through a unit and a host of their own."""
        unit = UnitDaemon([line], key=keys.datagram_key, cell_key=keys.cell_key, session=seed + commands)
        driver = Driver(names, keys.datagram_key, ("127.0.0.1", 0), [unit.address], session_seed=seed + commands)
        unit.start()
        driver.start()
        heard: set[int] = set()

        def all_heard(within_s: float) -> bool:
            driver.command("ping", group=1)
            return wait_until(lambda: heard.update(one["key"] for one in driver.replies()) or len(heard) == 3, within_s)

        try:
            assert wait_until(lambda: driver.statistics()["clock_frames"] > 100, 10.0)
            for _ in range(commands):
                driver.command("ping", group=1)
                time.sleep(0.005)
            driver.replies()
            for _ in range(leaps):
                driver.leap_command_counter()
                # A line may lose the command of the one leap that the cells obey.
                if any(all_heard(0.5) for _ in range(3)):
                    break
            if len(heard) < 3:
                all_heard(3.0)
            return len(heard)
        finally:
            driver.stop()
            unit.stop()

    try:
        assert pinged(50, 0) == 3
        assert pinged(1, 0) == 0
        assert pinged(2, 3) == 3
    finally:
        skin.stop()
