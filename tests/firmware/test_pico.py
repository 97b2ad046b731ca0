# SPDX-License-Identifier: Apache-2.0
"""The firmware on an emulated Raspberry Pi Pico: boots, joins a skin, reads its sensors, obeys, and is the host's."""

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest

from key_frames import check, heard, keys_of, said, written
from robotskin import firmware as firmware_of_host
from robotskin_lab import firmware
from robotskin_lab.chip.emulated_pico import FOLDER, EmulatedPico, missing
from robotskin_lab.chip.pico_image import PicoImage, boot_checksum, build_pico, cell_keys
from robotskin_lab.chip.pico_replay import RECORDING, replay
from robotskin_lab.chip.pico_skin import UID, PicoSkin, wrong_samples
from robotskin_lab.chip_command import build

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())
VCNL4010, LIS3DH, TMP102 = 0x13, 0x18, 0x48
PARTS = {
    VCNL4010: {0x87: 0x12, 0x88: 0x34},
    LIS3DH: {0x28: 0x00, 0x29: 0x10, 0x2A: 0x00, 0x2B: 0xF0, 0x2C: 0x80, 0x2D: 0x3E},
    TMP102: {0x00: 0x19, 0x01: 0x80},
}
INPUTS = [0, 2048, 3000, 0, 876]
"""Forces 1 to 3, nothing, the chip's temperature."""
READ = {
    "proximity": 0x1234,
    "force_1": 0,
    "force_2": 146,
    "force_3": 399,
    "acceleration_x": 66,  # 4096 of 16000 a g
    "acceleration_y": -65,
    "acceleration_z": 256,
    "temperature_1": 54,
    "temperature_2": 816,
}


@pytest.fixture(scope="module")
def image() -> PicoImage:
    return build_pico()


@pytest.fixture
def key(seed: int) -> bytes:
    return Random(seed).randbytes(firmware.CELL_KEY_BYTES)


@pytest.fixture
def pico(image: PicoImage, key: bytes, seed: int, tmp_path: Path) -> Iterator[EmulatedPico]:
    (tmp_path / "cell.uf2").write_bytes(image.uf2(UID, cell_keys(key, UID)))
    made = EmulatedPico(tmp_path / "cell.uf2", seed)
    made.sensors(PARTS, INPUTS)
    yield made
    made.close()


def test_the_image_is_one_that_the_chip_boots(image: PicoImage) -> None:
    assert image.flash[252:256] == boot_checksum(image.flash[:252]).to_bytes(4, "little")
    assert image.ram_bytes < 256 * 1024
    blocks = image.uf2(7, None)
    assert len(blocks) % 512 == 0
    assert all(blocks[at : at + 4] == b"UF2\n" for at in range(0, len(blocks), 512))


def test_it_joins_a_skin_samples_its_sensors_and_obeys(pico: EmulatedPico, key: bytes) -> None:
    skin = PicoSkin(pico, 3, key)
    assert skin.run_until(lambda: skin.named == 4, 100)
    skin.run(40)
    skin.samples.clear()
    skin.run(80)
    assert abs(len(skin.samples) - 80) <= 4
    own = skin.of_pico()
    assert len(own) >= 19
    assert wrong_samples(own, READ) == 0
    assert not any(sample["fault"] for sample in own)
    assert skin.bad == 0
    assert pico.told["framing_errors"] == 0
    assert pico.told["said"] == []
    assert pico.registers(VCNL4010)[0x82] == 7
    assert pico.registers(LIS3DH)[0x20] == 0x77
    skin.driver.command("ping")
    assert skin.run_until(lambda: len({reply["key"] for reply in skin.replies}) == 4, 60)


def test_it_keeps_no_word_of_another_skins_host(pico: EmulatedPico, seed: int) -> None:
    """Ticks and commands under another secret: it is not named, and answers nothing."""
    skin = PicoSkin(pico, 0, Random(seed + 1).randbytes(firmware.CELL_KEY_BYTES))
    assert not skin.run_until(lambda: skin.of_pico() != [], 60)
    skin.driver.command("ping")
    skin.run(30)
    assert skin.replies == []


def test_a_part_that_is_pulled_is_told_and_started_anew_when_it_is_back(pico: EmulatedPico, key: bytes) -> None:
    skin = PicoSkin(pico, 0, key)
    assert skin.run_until(lambda: len(skin.of_pico()) > 12, 150)
    assert not skin.of_pico()[-1]["fault"]
    pico.unplug(LIS3DH)
    skin.run(60)
    assert skin.of_pico()[-1]["fault"]
    assert skin.of_pico()[-1]["proximity"] == READ["proximity"]
    pico.sensors({LIS3DH: PARTS[LIS3DH]})
    skin.run(60)
    assert not skin.of_pico()[-1]["fault"]
    assert pico.registers(LIS3DH)[0x20] == 0x77


@pytest.mark.parametrize(("percent", "heard"), [(-4, True), (4, True), (-7, False), (7, False)])
def test_lines_may_be_four_percent_off_and_not_seven(image, key, seed, tmp_path, percent, heard) -> None:
    (tmp_path / "cell.uf2").write_bytes(image.uf2(UID, cell_keys(key, UID)))
    pico = EmulatedPico(tmp_path / "cell.uf2", seed)
    skin = PicoSkin(pico, 0, key, percent)
    assert skin.run_until(lambda: len(skin.of_pico()) > 2, 60) == heard
    pico.close()


def test_noise_between_frames_costs_no_samples(pico: EmulatedPico, key: bytes, seed: int) -> None:
    random = Random(seed)
    skin = PicoSkin(pico, 3, key)
    assert skin.run_until(lambda: skin.named == 4, 100)
    skin.run(30)
    for _ in range(10):
        pico.send(random.randint(2, 4), random.randbytes(random.randint(1, 3)))
        skin.run(random.uniform(3, 8))
    skin.samples.clear()
    skin.run(80)
    assert abs(len(skin.samples) - 80) <= 4


def test_its_ticks_tell_how_old_they_are(pico: EmulatedPico, key: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """To ten microseconds, however long a tick has waited for its processor."""
    skin = PicoSkin(pico, 12, key)
    began_us: dict[int, float] = {}
    errors_us = []
    send, run = pico.send, pico.run

    def watched_send(port: int, data: bytes, percent: float = 0.0) -> None:
        name, fields = firmware.unpack(data)
        if port == 1 and name == "tick":
            began_us[fields["sequence"]] = skin.now
        send(port, data, percent)

    def watched_run(until_us: float) -> list[tuple[int, float, float, bytes]]:
        frames = run(until_us)
        for port, _, begin_us, frame in frames:
            name, fields = firmware.unpack(frame)
            if port != 1 and name == "tick" and fields["sequence"] in began_us:
                errors_us.append(4 * fields["age_4us"] - (begin_us - began_us[fields["sequence"]]))
        return frames

    monkeypatch.setattr(pico, "send", watched_send)
    monkeypatch.setattr(pico, "run", watched_run)
    skin.run(80)
    assert len(errors_us) > 150
    assert sorted(map(abs, errors_us))[len(errors_us) * 9 // 10] < 10


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc)")
def test_the_host_built_program_asks_the_same(key: bytes, seed: int, tmp_path: Path) -> None:
    keys, record = cell_keys(key, UID), tmp_path / "record.txt"
    (tmp_path / "cell.uf2").write_bytes(build_pico(options=[RECORDING]).uf2(UID, keys))
    pico = EmulatedPico(tmp_path / "cell.uf2", seed, record)
    pico.sensors(PARTS, INPUTS)
    skin = PicoSkin(pico, 3, key)
    skin.run(150)
    pico.close()
    compared = replay(record, tmp_path, UID, keys)
    assert compared["differences"] == 0
    assert compared["samples"] >= 30
    assert compared["sent"] > 300
    lines = record.read_text().splitlines()
    at = next(number for number in range(len(lines) // 2, len(lines)) if lines[number].startswith("6 "))
    lines[at] = lines[at][:-1] + ("0" if lines[at][-1] != "0" else "1")
    record.write_text("\n".join(lines) + "\n")
    assert replay(record, tmp_path, UID, keys)["differences"] > 0


def answers(pico: EmulatedPico, port: int, frames: bytes, milliseconds: float) -> list[tuple[str, int, int]]:
    """What comes out of a port in a time after frames were sent to it."""
    pico.send(port, frames)
    ends, found = pico.now_us + 1000 * milliseconds, []
    while pico.now_us < ends:
        found += [heard(frame) for at, _, _, frame in pico.run(ends) if at == port]
    return found


def test_it_takes_keys_over_its_line_once_and_forgets_them_by_a_wire_alone(image, key, seed, tmp_path) -> None:
    uf2, flash, keys = tmp_path / "cell.uf2", tmp_path / "flash", cell_keys(key, UID)
    uf2.write_bytes(image.uf2(UID, None))
    pico = EmulatedPico(uf2, seed)
    pico.run(5000)
    assert answers(pico, 2, said("ask"), 5) == [("factory", UID, firmware_of_host.FIRMWARE_VERSION)]
    kept = ("kept", UID, check(keys, UID, "kept"))
    assert answers(pico, 2, written(keys, UID), 60) == [kept]
    assert answers(pico, 2, written(keys_of(seed + 1, UID), UID), 20) == [("refused", UID, 0)]
    assert answers(pico, 2, said("keep", UID, check(keys, UID, "keep")), 20) == [kept]
    pico.save_flash(flash)
    pico.run(pico.now_us + 250_000)
    skin = PicoSkin(pico, 0, key)
    skin.now = pico.now_us
    assert skin.run_until(lambda: len(skin.of_pico()) > 2, 200)
    pico.close()
    # After a power cycle it has them, and is a cell at once.
    pico = EmulatedPico(uf2, seed + 1, kept=flash)
    pico.run(20_000)
    others = answers(pico, 2, written(keys_of(seed + 1, UID), UID), 20)
    assert others
    assert {name for name, *_ in others} <= {"tick", "join"}
    pico.save_flash(flash)
    pico.close()
    # A wire at power-up clears them.
    pico = EmulatedPico(uf2, seed + 2, kept=flash, forget=True)
    pico.run(20_000)
    assert [name for name, *_ in answers(pico, 2, said("ask"), 5)] == ["factory"]
    assert pico.told["said"] == []
    pico.close()


def test_two_picos_hear_each_other_pin_to_pin(image: PicoImage, tmp_path: Path) -> None:
    files = []
    for uid in (11, 22):
        files.append(tmp_path / f"{uid}.uf2")
        files[-1].write_bytes(image.uf2(uid, keys_of(1, uid)))
    ran = subprocess.run(["node", FOLDER / "two.mjs", *files, "30"], capture_output=True, text=True, check=True)
    for wired, told in zip((2, 3), json.loads(ran.stdout), strict=True):
        heard: dict[int, list[int]] = {}
        for port, frame in told["frames"]:
            name, fields = firmware.unpack(bytes.fromhex(frame))
            if name == "tick":
                heard.setdefault(port, []).append(fields["heard"])
        assert sum(heard[wired]) >= len(heard[wired]) - 2 > 10
        assert not any(any(heard[port]) for port in heard if port != wired)
        assert told["framing_errors"] == 0
        assert told["said"] == []


def test_a_file_that_is_not_named_is_named_by_the_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    build("pico", uid=UID)
    assert (tmp_path / f"cell_{UID}.uf2").stat().st_size > 0
