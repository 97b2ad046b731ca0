# SPDX-License-Identifier: Apache-2.0
"""A cell without keys takes those of a skin over its line, once, and obeys under them from then on."""

import contextlib
import json
import os
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from key_frames import check, heard, keys_of, of_key, said
from robotskin import firmware
from robotskin.cli import main
from robotskin.driver import Driver
from robotskin.keys import KeptCellKeys, SkinKeys, SkinKeysError
from robotskin.serial_lines import CellRunner, HostCell, SerialError, SetSensors, UnitDaemon, commission
from robotskin_lab import firmware as laboratory

UID, GROUP = 0x1234_5678, 1 << 16


def wait_until(holds, within_s: float = 20.0) -> bool:
    ends = time.monotonic() + within_s
    while time.monotonic() < ends:
        if holds():
            return True
        time.sleep(0.01)
    return False


class Factory:
    """A host-built cell without keys on a pseudo-terminal, spoken to frame by frame."""

    def __init__(self, line: Path) -> None:
        sensors = SetSensors(1)
        sensors.set(np.zeros((1, 9), dtype=np.int32))
        ends = [(-1, 0, -1), (-1, 0, 0), (-1, 0, -1), (-1, 0, -1)]
        self.cell = CellRunner([HostCell(UID, ends, 0, 1, factory=True)], None, sensors, [(str(line), True)])
        self.cell.start()
        self.line = os.open(line, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        os.set_blocking(self.line, False)
        self.come = b""

    def close(self) -> None:
        os.close(self.line)
        self.cell.stop()

    def say(self, step: str, *words: int) -> None:
        os.write(self.line, said(step, *words))

    def say_key(self, step: str, key: bytes) -> None:
        os.write(self.line, of_key(step, key))

    def heard(self) -> list[tuple[str, int, int]]:
        with contextlib.suppress(BlockingIOError):
            self.come += os.read(self.line, 1 << 16)
        frames = [self.come[at : at + 20] for at in range(0, len(self.come) // 20 * 20, 20)]
        self.come = self.come[20 * len(frames) :]
        return [heard(frame) for frame in frames]

    def answer(self) -> tuple[str, int, int]:
        """Step and two words of the next frame."""
        found: list[tuple[str, int, int]] = []
        assert wait_until(lambda: bool(found.extend(self.heard()) or found))
        (only,) = found
        return only

    def silent(self) -> bool:
        time.sleep(0.05)
        return not self.heard()


@pytest.fixture
def factory(tmp_path: Path) -> Iterator[Factory]:
    made = Factory(tmp_path / "line")
    yield made
    made.close()


def test_a_cell_without_keys_answers_key_frames_alone(factory: Factory) -> None:
    assert factory.silent()
    os.write(factory.line, laboratory.pack("tick", {"sequence": 1, "root": 1}))
    os.write(factory.line, laboratory.pack("command", {"target": firmware.ID_ALL, "operation": 2, "counter": 1}))
    assert factory.silent()
    factory.say("ask")
    assert factory.answer() == ("factory", UID, firmware.FIRMWARE_VERSION)
    assert factory.cell.given_keys(0) is None


def test_it_keeps_no_mixture_and_no_other_cells_keys(factory: Factory, seed: int) -> None:
    right, other, neighbours = keys_of(seed, UID), keys_of(seed + 1, UID), keys_of(seed, UID + 1)
    factory.say("keep", UID, check(right, UID, "keep"))
    assert factory.answer() == ("refused", UID, 0)  # nothing has come
    factory.say_key("group", right[:16])
    factory.say("keep", UID, check(right, UID, "keep"))
    assert factory.answer() == ("refused", UID, 0)  # half has
    factory.say_key("own", other[16:])
    for keys in (right, other):
        factory.say("keep", UID, check(keys, UID, "keep"))
        assert factory.answer() == ("refused", UID, 0)
    factory.say_key("own", neighbours[16:])
    factory.say("keep", UID + 1, check(neighbours, UID + 1, "keep"))
    assert factory.answer() == ("refused", UID, 0)
    assert factory.cell.given_keys(0) is None


def test_it_says_so_only_when_they_are_stored_and_takes_no_others(factory: Factory, seed: int) -> None:
    keys, others = keys_of(seed, UID), keys_of(seed + 1, UID)
    factory.say_key("own", keys[16:])
    factory.say_key("group", keys[:16])
    factory.say("keep", UID, check(keys, UID, "keep"))
    assert wait_until(lambda: factory.cell.given_keys(0) == keys)
    assert factory.silent()
    factory.cell.note_kept(0)
    factory.say("keep", UID, check(keys, UID, "keep"))  # an answer that was lost is given again
    assert factory.answer() == ("kept", UID, check(keys, UID, "kept"))
    factory.say_key("group", others[:16])
    factory.say_key("own", others[16:])
    factory.say("keep", UID, check(others, UID, "keep"))
    assert factory.answer() == ("refused", UID, 0)
    factory.say("ask")
    assert factory.answer() == ("refused", UID, 0)
    assert factory.cell.given_keys(0) == keys
    # Then it runs, and reads no key frames any more.
    assert wait_until(lambda: any(name == "tick" for name, *_ in factory.heard()))
    for number in range(20):
        factory.say_key("group", others[:16])
        factory.say_key("own", others[16:])
        factory.say("keep" if number % 2 else "ask", UID, check(others, UID, "keep"))
    time.sleep(0.1)
    assert {name for name, *_ in factory.heard()} <= {"tick", "join"}
    assert factory.cell.given_keys(0) == keys


def robotskin(*words: object) -> tuple[int, str]:
    told = CliRunner().invoke(main.app, [str(word) for word in words])
    return told.exit_code, told.output


def begin_cell(line: Path, kept: Path) -> subprocess.Popen[str]:
    command = [Path(sys.executable).with_name("robotskin"), "cell", line, "--make", "--kept", kept, "--uid", 7]
    started = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True)
    assert wait_until(line.exists)
    return started


def end(cell: subprocess.Popen[str]) -> str:
    cell.terminate()
    return cell.communicate(timeout=20)[0]


def obeys(line: Path, keys: SkinKeys, seed: int, within_s: float) -> bool:
    """Whether the cell answers a section unit with these keys."""
    unit = UnitDaemon([str(line)], key=keys.datagram_key, cell_key=keys.cell_key, session=seed + 1)
    driver = Driver([GROUP | 1], keys.datagram_key, ("127.0.0.1", 0), [unit.address])
    for one in (unit, driver):
        one.start()
    try:

        def answers() -> bool:
            driver.command("ping", group=1)
            time.sleep(0.05)
            return any(reply["operation"] == "ping" for reply in driver.replies())

        return wait_until(answers, within_s)
    finally:
        driver.stop()
        unit.stop()


def test_a_cell_is_commissioned_by_the_command_once_and_obeys_these_keys_alone(tmp_path: Path, seed: int) -> None:
    line, kept, own, other = (tmp_path / name for name in ("line", "cell.keys", "skin.key", "other.key"))
    for file in (own, other):
        assert robotskin("keys", file)[0] == 0
    keys, others = SkinKeys.load(own), SkinKeys.load(other)
    cell = begin_cell(line, kept)
    try:
        status, told = robotskin("commission", line, "--key", own, "--uid", 8)
        assert status == 2
        assert "found cell 7, expected cell 8" in told
        assert not kept.exists()
        status, told = robotskin("commission", line, "--key", own, "--uid", 7)
        assert (status, "cell 7 has its keys" in told) == (0, True), told
        assert stat.S_IMODE(kept.stat().st_mode) == 0o600
        assert keys.secret.hex() not in kept.read_text()
        assert keys.cell_key.hex() not in kept.read_text()
        time.sleep(0.3)
        status, told = robotskin("commission", line, "--key", other, "--seconds", "0.5")
        assert status == 2
        assert "has keys already" in told
        assert obeys(line, keys, seed, 20.0)
        assert "waits for its keys" in end(cell)
        # A power cycle changes nothing of that.
        cell = begin_cell(line, kept)
        status, told = robotskin("commission", line, "--key", other, "--seconds", "0.5")
        assert (status, "has keys already" in told) == (2, True), told
        assert obeys(line, keys, seed, 20.0)
        assert not obeys(line, others, seed, 1.0)
        # Its keys are cleared by hand: it takes others.
        end(cell)
        kept.unlink()
        cell = begin_cell(line, kept)
        assert robotskin("commission", line, "--key", other)[0] == 0
        assert obeys(line, others, seed, 20.0)
    finally:
        end(cell)


def test_a_line_without_a_cell_is_told(tmp_path: Path, seed: int) -> None:
    secret = SkinKeys.of_seed(seed).cell_key
    with pytest.raises(SerialError, match="No such file"):
        commission(str(tmp_path / "none"), secret, within_s=0.2)
    own, end_of_it = os.openpty()
    try:
        with pytest.raises(SerialError, match="found no cell"):
            commission(os.ttyname(end_of_it), secret, within_s=0.2)
    finally:
        os.close(own)
        os.close(end_of_it)


def test_kept_keys_of_another_cell_and_of_no_cell_are_refused(tmp_path: Path, seed: int) -> None:
    file = tmp_path / "cell.keys"
    assert KeptCellKeys.load(file, 7) is None
    KeptCellKeys(7, keys_of(seed, 7)).save(file)
    assert KeptCellKeys.load(file, 7) == KeptCellKeys(7, keys_of(seed, 7))
    with pytest.raises(SkinKeysError, match="found those of cell 7, expected cell 8"):
        KeptCellKeys.load(file, 8)
    file.write_text(json.dumps({"format": "robotskin cell keys 1", "uid": 7, "keys": "00"}))
    with pytest.raises(SkinKeysError, match="is no file"):
        KeptCellKeys.load(file, 7)
    status, told = robotskin("cell", tmp_path / "line", "--make")
    assert (status, "--kept" in told) == (2, True), told
