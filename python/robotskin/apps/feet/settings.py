# SPDX-License-Identifier: Apache-2.0
"""The parameters of feeling feet, read from a TOML file."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec

from robotskin.apps.feet.motors import SimulatedVibrators
from robotskin.errors import InputError

FILE = Path(__file__).with_name("settings.toml")
"""The file to copy."""


HIGHEST_SHARE = 1.0
"""Of the force that starts a touch, below which it ends: above 1 a touch would end as it starts."""
UPDATES_HZ = (20.0, 250.0)
"""With the slowest one duty may get lost within the 100 ms after which motors stop; the fastest is the control rate."""
STOPS_S = 0.1
"""After cells are lost, so late at most motors are still."""
LOST_S = (0.01, STOPS_S - 1 / UPDATES_HZ[1] - SimulatedVibrators.RUNS_DOWN_S)
"""A cell sends every 4 ms. Once it counts as lost, the next control period stops its motor, which then runs down."""


class Part(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Numbers of one table; all finite and greater than 0."""

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            value = getattr(self, name)
            if isinstance(value, float) and not 0 < value < math.inf:
                raise ValueError(f"{name} = {value:g}: must be finite and greater than 0")


class Touch(Part, frozen=True):
    """What counts as a touch, and which touches are landings."""

    on_n: float
    off_share: float
    residue_share: float
    free_s: float
    front_alone_s: float
    calm_m_s2: float
    calm_s: float
    zero_s: float

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("off_share", "residue_share"):
            if getattr(self, name) > HIGHEST_SHARE:
                raise ValueError(f"{name} = {getattr(self, name):g}: must be more than 0 and at most {HIGHEST_SHARE:g}")


class Nearness(Part, frozen=True):
    """When a landing is announced."""

    within_m: float
    ahead_s: float


class Vibration(Part, frozen=True):
    """From the load of a region to the duty of its motor."""

    silent_share: float
    full_share: float
    update_hz: float
    lost_s: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.full_share <= self.silent_share:
            raise ValueError(f"full_share = {self.full_share:g}: must be more than silent_share")
        least, most = UPDATES_HZ
        if not least <= self.update_hz <= most:
            raise ValueError(f"update_hz = {self.update_hz:g}: must be {least:g} to {most:g}")
        least_s, most_s = LOST_S
        if not least_s <= self.lost_s <= most_s:
            raise ValueError(
                f"lost_s = {self.lost_s:g}: must be {least_s:g} to {most_s:.3f}, so that motors are still within "
                f"{STOPS_S:g} s"
            )


class Settings(Part, frozen=True):
    """Of both feet."""

    touch: Touch
    nearness: Nearness
    vibration: Vibration


def read_settings(file: Path = FILE) -> Settings:
    """Read a file such as `FILE`.

    Raises:
        InputError: the file is not there or cannot be used; names the field.
    """
    try:
        return msgspec.toml.decode(file.read_bytes(), type=Settings)
    except OSError as error:
        raise InputError(f"settings {file}: {error.strerror}; copy {FILE}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"settings {file}: byte {error.start} is no UTF-8 text; compare with {FILE}") from error
    except (msgspec.DecodeError, msgspec.ValidationError) as error:
        raise InputError(f"settings {file}: {error}; compare with {FILE}") from error
