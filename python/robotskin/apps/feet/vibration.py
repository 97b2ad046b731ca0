# SPDX-License-Identifier: Apache-2.0
"""From the load under a foot to the duty of three motors; motors simulated, and on a serial line."""

from __future__ import annotations

import os
import termios
import tty
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robotskin.apps.feet.exoskeleton import REGIONS, Region
from robotskin.apps.feet.settings import Vibration
from robotskin.errors import InputError

Array = NDArray[np.float64]
STEPS = 255
"""Of the pulse width."""


class Vibrators(Protocol):
    """Three motors on the arm: front, centre, back."""

    def set_duty(self, duty: Array) -> None:
        """(3,) 0 to 1."""


class Calibration:
    """What each cell feels while the wearer stands still, so that felt force becomes load.

    How much of the load the insole carries beside a cell differs from cell to cell and is not known beforehand. While
    the wearer stands on both feet each region of both soles carries the same share of the weight.

    Args:
        weight_n: of wearer and exoskeleton.
        felt_n: (14,) newton, mean of each cell while standing; NaN for one that was not heard.

    Raises:
        InputError: a region without any cell that felt the standing weight.
    """

    LEAST_FELT_N = 0.3

    def __init__(self, weight_n: float, felt_n: Array) -> None:
        self.region_n = weight_n / (2 * len(Region))
        """What a region carries while the wearer stands."""
        usable = np.isfinite(felt_n) & (np.nan_to_num(felt_n) > self.LEAST_FELT_N)
        self.load_per_newton = np.where(usable, self.region_n / np.where(usable, felt_n, 1.0), np.nan)
        """(14,) newton of the region for a newton of the cell; NaN: the cell is not used."""
        for foot in range(2):
            for region in Region:
                if not usable[7 * foot : 7 * foot + 7][region == REGIONS].any():
                    raise InputError(
                        f"calibration: no cell of the {region.name.lower()} of the {('left', 'right')[foot]} sole felt "
                        f"{self.LEAST_FELT_N:g} N; let the wearer stand on both feet"
                    )

    def loads(self, foot: int, force_n: Array, heard: NDArray[np.bool_]) -> Array:
        """(3,) newton on each region of a foot, from its cells (7,); NaN where none of its cells is heard."""
        scale = self.load_per_newton[7 * foot : 7 * foot + 7]
        each = np.where(heard, scale * force_n, np.nan)
        result = np.full(len(Region), np.nan)
        for region in Region:
            known = each[(region == REGIONS) & np.isfinite(each)]
            if len(known):
                result[region] = known.mean()
        return result


def duty_of(loads_n: Array, calibration: Calibration, settings: Vibration) -> Array:
    """(3,) duty for the loads (3,) of the regions: proportional between two loads, 0 where a load is not known."""
    silent, full = settings.silent_share * calibration.region_n, settings.full_share * calibration.region_n
    duty = np.clip((np.nan_to_num(loads_n, nan=0.0) - silent) / (full - silent), 0.0, 1.0)
    return np.asarray(np.round(duty * STEPS) / STEPS)


class SimulatedVibrators:
    """Motors with an unbalanced weight: below a duty they do not turn, and they need time to start and to stop.

    A driver's watchdog stops them when no duty has come for `WATCHDOG_S`.
    """

    DEAD_DUTY = 0.17
    START_S, STOP_S = 0.030, 0.040
    WATCHDOG_S = 0.1

    def __init__(self) -> None:
        self.strength = np.zeros(len(Region))
        """(3,) what the wearer feels, 1: full speed."""
        self.duty = np.zeros(len(Region))
        """(3,) as told last; 0 once nothing was told for long."""
        self._told_s = -np.inf
        self._now_s = 0.0

    def set_duty(self, duty: Array) -> None:
        """(3,) 0 to 1."""
        self.duty = np.array(duty)
        self._told_s = self._now_s

    def step(self, now_s: float) -> None:
        """Let time pass until `now_s`."""
        seconds, self._now_s = now_s - self._now_s, now_s
        if now_s - self._told_s > self.WATCHDOG_S:
            self.duty = np.zeros(len(Region))
        goal = np.where(self.duty > self.DEAD_DUTY, self.duty, 0.0)
        settles = np.where(goal > self.strength, self.START_S, self.STOP_S)
        self.strength += np.minimum(seconds / settles, 1.0) * (goal - self.strength)


class SerialVibrators:
    """Motors behind a microcontroller on a serial line.

    Each duty is a line of ASCII, `V front centre back`, three whole numbers of 0 to 255. The microcontroller has to
    stop its motors when no line has come for 100 ms. The line has 115200 baud, eight bits and no parity.

    Raises:
        InputError: a device that cannot be opened, or is no terminal.
    """

    def __init__(self, device: str | Path) -> None:
        self._device = device
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
            tty.setraw(self._line)
            attributes = termios.tcgetattr(self._line)
            attributes[4] = attributes[5] = termios.B115200
            termios.tcsetattr(self._line, termios.TCSANOW, attributes)
        except termios.error as error:
            os.close(self._line)
            raise InputError(f"serial line {device}: cannot be set to 115200 baud: {error.args[-1]}") from error

    def set_duty(self, duty: Array) -> None:
        """(3,) 0 to 1. A line that takes nothing loses it: the next one comes soon.

        Raises:
            InputError: the line is gone, such as one that was pulled out.
        """
        numbers = np.rint(np.clip(np.nan_to_num(duty), 0.0, 1.0) * STEPS).astype(int)
        try:
            os.write(self._line, f"V {numbers[0]} {numbers[1]} {numbers[2]}\n".encode())
        except BlockingIOError:
            return
        except OSError as error:
            raise InputError(
                f"serial line {self._device}: {error.strerror}; its motors stop: plug it in and begin anew"
            ) from error

    def close(self) -> None:
        """Silence the motors, if the line is still there, and close it."""
        try:
            self.set_duty(np.zeros(len(Region)))
        except InputError:
            pass  # without lines the motors stop
        finally:
            os.close(self._line)
