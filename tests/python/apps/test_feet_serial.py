# SPDX-License-Identifier: Apache-2.0
"""Motors of feeling feet on a serial line: what is sent, lines that are no terminal, that are full or pulled out."""

import itertools
import os
import pty
import termios
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robotskin.apps.feet.serial_line import STUCK_S, TEST_S, SerialVibrators
from robotskin.cli import main
from robotskin.errors import InputError


@pytest.fixture
def line() -> Iterator[tuple[int, str]]:
    """The microcontroller's end of a line, and the name of ours."""
    theirs, ours = pty.openpty()
    yield theirs, os.ttyname(ours)
    for end in (theirs, ours):
        os.close(end)


def fill(motors: SerialVibrators) -> None:
    """Send until the line takes no more."""
    for number in itertools.cycle(range(256)):
        motors.set_duty(np.full(3, number / 255))
        if motors._full_since_s is not None:
            return


def keep_sending(motors: SerialVibrators, seconds: float) -> None:
    """Duties of 1, fifty a second."""
    until_s = time.monotonic() + seconds
    while time.monotonic() < until_s:
        motors.set_duty(np.ones(3))
        time.sleep(0.02)


def read_all(end: int) -> bytes:
    """What was sent and not read yet."""
    os.set_blocking(end, False)
    read = b""
    try:
        while True:
            read += os.read(end, 4096)
    except BlockingIOError:
        return read


def test_real_motors_hear_a_line_of_text(line: tuple[int, str]) -> None:
    theirs, device = line
    motors = SerialVibrators(device)
    motors.set_duty(np.array([0.0, 0.5, 1.0]))
    assert os.read(theirs, 100) == b"V 0 128 255\n"
    motors.set_duty(np.array([np.nan, 2.0, -1.0]))
    assert os.read(theirs, 100) == b"V 0 255 0\n"
    motors.close()
    assert os.read(theirs, 100) == b"V 0 0 0\n", "closed motors are silent"
    with pytest.raises(InputError, match="no_such_line"):
        SerialVibrators("/dev/no_such_line")


def test_the_line_is_set_up_whatever_was_left(line: tuple[int, str]) -> None:
    _, device = line
    other = os.open(device, os.O_RDWR | os.O_NOCTTY)
    left = termios.tcgetattr(other)
    left[2] = (left[2] | termios.CSTOPB | termios.CRTSCTS) & ~termios.CLOCAL
    left[4] = left[5] = termios.B9600
    termios.tcsetattr(other, termios.TCSANOW, left)
    assert termios.tcgetattr(other)[2] & termios.CRTSCTS, "the test's own ground"
    motors = SerialVibrators(device)
    found = termios.tcgetattr(other)
    assert not found[2] & (termios.CSTOPB | termios.CRTSCTS | termios.PARENB)
    assert found[2] & termios.CLOCAL
    assert found[4] == found[5] == termios.B115200
    motors.close()
    os.close(other)


def test_a_line_that_takes_nothing_is_named_after_half_a_second(line: tuple[int, str]) -> None:
    _, device = line
    motors = SerialVibrators(device)
    fill(motors)
    began = time.monotonic()
    with pytest.raises(InputError, match=rf"{device}: took nothing for 0\.\d s; its motors count as off"):
        keep_sending(motors, 4 * STUCK_S)
    assert time.monotonic() - began >= 0.9 * STUCK_S
    motors.close()
    assert time.monotonic() - began < 2 * STUCK_S, "closing does not wait for it"


def test_a_line_that_is_full_for_a_moment_goes_on(line: tuple[int, str]) -> None:
    theirs, device = line
    motors = SerialVibrators(device)
    fill(motors)
    time.sleep(1.2 * STUCK_S)
    read_all(theirs)
    motors.set_duty(np.zeros(3))
    motors.set_duty(np.zeros(3))
    assert read_all(theirs).endswith(b"V 0 0 0\n")
    motors.close()


def test_a_line_taken_in_parts_is_finished_before_the_next_begins(
    line: tuple[int, str], seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    theirs, device = line
    draw, write = np.random.default_rng(seed), os.write

    def takes_a_part(end: int, text: bytes) -> int:
        count = int(draw.integers(0, len(text) + 1))
        if not count:
            raise BlockingIOError
        return write(end, text[:count])

    motors = SerialVibrators(device)
    monkeypatch.setattr(os, "write", takes_a_part)
    sent = set()
    for duty in draw.integers(0, 256, (300, 3)):
        sent.add("V {} {} {}".format(*duty))
        motors.set_duty(duty / 255)
    motors.close()
    heard = read_all(theirs).decode().split("\n")
    assert heard.pop() == "", "the last line ends"
    assert len(heard) > 50
    assert set(heard) <= sent | {"V 0 0 0"}
    assert heard[-1] == "V 0 0 0"


def test_a_file_that_is_no_terminal_is_refused_and_keeps_its_text(tmp_path: Path) -> None:
    notes = tmp_path / "notes.txt"
    notes.write_text("what I must not forget")
    answer = CliRunner().invoke(main.app, ["app", "feet", "--test-motors", "--serial", str(notes)])
    assert answer.exit_code == 2
    assert notes.read_text() == "what I must not forget"
    with pytest.raises(InputError, match=r"notes\.txt: is no terminal.*ls /dev/tty"):
        SerialVibrators(notes)
    with pytest.raises(InputError, match="/dev/null"):
        SerialVibrators("/dev/null")


def test_a_line_that_is_pulled_out_is_named_and_closes() -> None:
    theirs, ours = pty.openpty()
    device = os.ttyname(ours)
    motors = SerialVibrators(device)
    os.close(theirs)
    os.close(ours)
    with pytest.raises(InputError, match=device):
        motors.set_duty(np.ones(3))
    motors.close()


def test_each_motor_is_tried_without_a_walk(line: tuple[int, str]) -> None:
    theirs, device = line
    heard: list[tuple[float, bytes]] = []

    def listen() -> None:
        text = b""
        while not text.endswith(b"V 0 0 0\nV 0 0 0\n"):
            text += os.read(theirs, 100)
            heard.append((time.monotonic(), text))

    listener = threading.Thread(target=listen, daemon=True)
    listener.start()
    answer = CliRunner().invoke(main.app, ["app", "feet", "--test-motors", "--serial", device])
    listener.join(10)
    assert answer.exit_code == 0, answer.output
    assert answer.output.split() == ["front", "centre", "back"]
    lines = heard[-1][1].decode().splitlines()
    runs = [(duty, len(list(same))) for duty, same in itertools.groupby(lines)]
    assert [duty for duty, _ in runs] == ["V 255 0 0", "V 0 255 0", "V 0 0 255", "V 0 0 0"]
    assert min(count for _, count in runs[:3]) > TEST_S / 0.1, "often enough for a watchdog of 100 ms"
    assert heard[-1][0] - heard[0][0] + 0.05 >= 3 * TEST_S


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--headless", "--serial", "/dev/null"], "does not wait for the clock"),
        (["--headless", "--test-motors"], "does not wait for the clock"),
        (["--test-motors"], "needs --serial"),
    ],
)
def test_real_motors_need_the_clock_and_a_line(options: list[str], complaint: str) -> None:
    answer = CliRunner().invoke(main.app, ["app", "feet", *options])
    assert answer.exit_code == 2
    assert complaint in " ".join(answer.output.replace("│", " ").split())
