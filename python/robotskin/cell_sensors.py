# SPDX-License-Identifier: Apache-2.0
"""Sensors of a host-built cell as a plug-in: one method that says what they read.

In: a name, `MODULE:CLASS` or the path of a shared library. Out: readings in counts. A plug-in in Python has
`read(seconds) -> Reading`; one in C or C++ is a library with the function `bool rs_board_sense(rs_sample*)`, as a
chip's board has it (`firmware/chip/board.h`).
"""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.errors import RobotskinError


class SensorsError(RobotskinError):
    """Sensors that cannot be had, or that read what no cell can send; the message names them."""


@dataclass(frozen=True)
class Reading:
    """What the sensors of one cell read. None: that sensor is missing, which the cell tells the host.

    proximity: 0 to 1; force: 3 newton, 0 to 10; acceleration: 3 g of specific force, cell frame (at rest, with the cell
    upward: 0, 0, 1); temperature: 2 degrees Celsius.
    """

    proximity: float | None = None
    force: tuple[float, float, float] | None = None
    acceleration: tuple[float, float, float] | None = None
    temperature: tuple[float, float] | None = None


@runtime_checkable
class Sensors(Protocol):
    """A plug-in."""

    def read(self, seconds: float) -> Reading:
        """What the sensors read now, `seconds` after the cell started; called some 500 times a second."""


class Still:
    """Nothing is near, nothing touches, the cell lies on its back at 25 degrees."""

    def read(self, seconds: float) -> Reading:
        """Always the same."""
        return Reading(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (25.0, 25.0))


def counts_of(reading: Reading, whose: str = "sensors") -> tuple[NDArray[np.int32], bool]:
    """(1, 9) counts, and whether a sensor is missing or at the end of its range.

    Raises SensorsError for a reading of another shape, which names `whose` it is.
    """
    counts = np.zeros((1, len(firmware.CHANNELS)), dtype=np.int32)
    fault, at = False, 0
    for name, width in (("proximity", 1), ("force", 3), ("acceleration", 3), ("temperature", 2)):
        value = getattr(reading, name)
        if value is None:
            fault = True
            at += width
            continue
        try:
            values = np.atleast_1d(np.asarray(value, dtype=float))
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape != (width,) or not np.isfinite(values).all():
            raise SensorsError(
                f"{whose}: {name} is {value!r}: give {width} finite numbers, or None where it is missing"
            )
        for one in values:
            _, signed, bits, step, _ = firmware.CHANNELS[at]
            least, most = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
            count = round(one / step)
            fault |= not least <= count <= most
            counts[0, at] = min(max(count, least), most)
            at += 1
    return counts, fault


def read_counts(name: str, sensors: Sensors, seconds: float) -> tuple[NDArray[np.int32], bool]:
    """`counts_of` what a plug-in reads `seconds` after the cell started.

    Raises SensorsError, naming the plug-in: it raised, answered no Reading, or one of another shape.
    """
    try:
        reading = sensors.read(seconds)
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        raise SensorsError(
            f"sensors {name}: read({seconds:.3f}) raised {type(error).__name__}: {error} ({place.filename}, line "
            f"{place.lineno}); for a sensor that is missing, give None in its Reading"
        ) from error
    if not isinstance(reading, Reading):
        raise SensorsError(
            f"sensors {name}: read({seconds:.3f}) answered {reading!r}: give a robotskin.cell_sensors.Reading"
        )
    return counts_of(reading, f"sensors {name}")


def made_sensors(name: str) -> Sensors:
    """The plug-in `MODULE:CLASS`, made without arguments; modules are looked for in the folder in which one works, too.

    Raises SensorsError: no such module or class, one that cannot be made, or that has no `read`.
    """
    module, _, wanted = name.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        made = getattr(importlib.import_module(module), wanted)()
    except Exception as error:
        raise SensorsError(
            f"sensors {name}: {type(error).__name__}: {error}; give MODULE:CLASS, made without arguments, or the path "
            "of a library (.so)"
        ) from error
    if not isinstance(made, Sensors):
        raise SensorsError(f"sensors {name}: {wanted} has no method read(seconds) that gives a Reading")
    return made
