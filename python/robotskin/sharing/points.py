# SPDX-License-Identifier: Apache-2.0
"""The whole skin as rows of numbers, a row a cell: what point clouds and packed messages of others hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotskin import firmware
from robotskin.record import Frame
from robotskin.sharing.poses import Floats
from robotskin.skin import Health


def channel_names(column: str, channels: int) -> list[str]:
    """The names of the channels of a sensor: axes have letters, other channels numbers from 1."""
    if channels == 1:
        return [column]
    axes = "xyz" if column in ("acceleration", "angular_velocity") else "123456789"
    return [f"{column}_{axes[i]}" for i in range(channels)]


SENSORS = [(column, channels) for _, column, channels, _, _ in firmware.SENSORS]
CHANNELS = [name for column, channels in SENSORS for name in channel_names(column, channels)]
PLACE = ["x", "y", "z", "normal_x", "normal_y", "normal_z"]
FIELDS = (*PLACE, *CHANNELS, "force", "distance", "age_s", "health", "cell")
"""The columns of `points`: metres in the base frame, the outward normal, every channel of every sensor in SI units,
the sum of a cell's forces in newton, metres to what is near, seconds since the sample, `Health`, the cell."""


def points(frame: Frame, base_from_cell: Floats) -> NDArray[np.float32]:
    """(N, F) the skin of a moment, a column for each of `FIELDS`.

    What a cell measures is NaN unless the cell is alive: stale values never look fresh.
    """
    skin = frame.skin
    count = len(skin)
    out = np.empty((count, len(FIELDS)), dtype="<f4")
    out[:, 0:3] = base_from_cell[:, :3, 3]
    out[:, 3:6] = base_from_cell[:, :3, 2]
    at = len(PLACE)
    for column, channels in SENSORS:
        out[:, at : at + channels] = np.asarray(getattr(skin, column)).reshape(count, channels)
        at += channels
    out[:, at] = np.asarray(skin.normal_force).sum(axis=1)
    out[:, at + 1] = skin.distance
    health = np.asarray(skin.health)
    out[health != int(Health.alive), len(PLACE) : at + 2] = np.nan
    stamp_ns = np.asarray(skin.stamp_ns)
    out[:, at + 2] = np.where(stamp_ns > 0, (frame.time_ns - stamp_ns) * 1e-9, np.inf)
    out[:, at + 3] = health
    out[:, at + 4] = np.arange(count)
    return out
