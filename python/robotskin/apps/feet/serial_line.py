# SPDX-License-Identifier: Apache-2.0
"""Real motors behind a microcontroller on a serial line."""

from __future__ import annotations

import contextlib
import os
import termios
import time
import tty
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import Region
from robotskin.apps.feet.motors import STEPS, Vibrators
from robotskin.errors import InputError

Array = NDArray[np.float64]
STUCK_S = 0.5
"""A line that took no byte for so long is told as stuck."""
CLOSES_S = 0.1
"""For so long closing tries to send the last duty, which is 0."""
RESENDS_S = 0.02
TEST_S = 0.5
"""For so long each motor runs when they are tried."""


class SerialVibrators:
    """Motors behind a microcontroller on a serial line.

    Each duty is a line of ASCII, `V front centre back`, three whole numbers of 0 to 255. The microcontroller has to
    stop its motors when no line has come for 100 ms. The line has 115200 baud, eight bits, no parity, one stop bit and
    no flow control; modem lines are ignored.

    Raises:
        InputError: a device that cannot be opened, or is no terminal.
    """

    def __init__(self, device: str | Path) -> None:
        self._device = device
        self._unsent = b""
        """What is left of a line of which a part was taken."""
        self._full_since_s: float | None = None
        """Since when the line takes nothing."""
        try:
            self._line = os.open(device, os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise InputError(f"serial line {device}: {error.strerror}") from error
        # Opened for writing, an ordinary file would lose its text to the first duty.
        if not os.isatty(self._line):
            os.close(self._line)
            raise InputError(
                f"serial line {device}: is no terminal, such as /dev/ttyUSB0; `ls /dev/tty*` lists those that are there"
            )
        try:
            _set_up(self._line)
        except termios.error as error:
            os.close(self._line)
            raise InputError(f"serial line {device}: cannot be set to 115200 baud: {error.args[-1]}") from error

    def set_duty(self, duty: Array) -> None:
        """(3,) 0 to 1. A line that takes nothing at this moment loses it: the next one comes soon.

        Raises:
            InputError: the line is gone, such as one that was pulled out, or took nothing for `STUCK_S`.
        """
        numbers = np.rint(np.clip(np.nan_to_num(duty), 0.0, 1.0) * STEPS).astype(int)
        self._send(f"V {numbers[0]} {numbers[1]} {numbers[2]}\n".encode())

    def _send(self, text: bytes) -> bool:
        """Whether the line took all of it."""
        # A line that was begun is finished first, or two of them would run together.
        self._unsent = self._unsent[self._taken(self._unsent) :]
        if self._unsent:
            return False
        taken = self._taken(text)
        self._unsent = text[taken:] if taken else b""
        return taken == len(text)

    def _taken(self, text: bytes) -> int:
        """How many bytes of it the line took."""
        if not text:
            return 0
        try:
            taken = os.write(self._line, text)
        except BlockingIOError:
            taken = 0
        except OSError as error:
            raise InputError(
                f"serial line {self._device}: {error.strerror}; its motors stop: plug it in and begin anew"
            ) from error
        now_s = time.monotonic()
        if taken:
            self._full_since_s = None
        elif self._full_since_s is None:
            self._full_since_s = now_s
        elif now_s - self._full_since_s >= STUCK_S:
            raise InputError(
                f"serial line {self._device}: took nothing for {now_s - self._full_since_s:.1f} s; its motors count as "
                "off: look at the microcontroller and its cable, and begin anew"
            )
        return taken

    def close(self) -> None:
        """Silence the motors, if the line takes it, and close it."""
        until_s = time.monotonic() + CLOSES_S
        try:
            while not self._send(b"V 0 0 0\n") and time.monotonic() < until_s:
                time.sleep(CLOSES_S / 20)
        except InputError:
            pass  # without lines the motors stop
        finally:
            self._forget()
            os.close(self._line)

    def _forget(self) -> None:
        """What the line did not take must not keep `close` waiting."""
        if self._full_since_s is None:
            return
        with contextlib.suppress(termios.error):  # a line that is gone holds nothing
            termios.tcflush(self._line, termios.TCOFLUSH)


def try_motors(motors: Vibrators, tell: Callable[[str], None]) -> None:
    """Run one motor after the other at full duty, each for `TEST_S`, then none.

    Args:
        motors: such as `SerialVibrators`.
        tell: takes the name of each region before its motor runs.

    Raises:
        InputError: the line is gone, or stuck.
    """
    for region in Region:
        tell(region.name.lower())
        duty = (np.arange(len(Region)) == region).astype(float)
        until_s = time.monotonic() + TEST_S
        while time.monotonic() < until_s:
            motors.set_duty(duty)
            time.sleep(RESENDS_S)
    motors.set_duty(np.zeros(len(Region)))


def _set_up(line: int) -> None:
    """115200 baud, 8N1, whatever the program before has left."""
    tty.setraw(line)
    attributes = termios.tcgetattr(line)
    attributes[0] &= ~(termios.IXON | termios.IXOFF | termios.IXANY)
    attributes[2] &= ~(termios.CSTOPB | termios.CRTSCTS)
    attributes[2] |= termios.CLOCAL | termios.CS8
    attributes[4] = attributes[5] = termios.B115200
    termios.tcsetattr(line, termios.TCSANOW, attributes)
